#include "server/metrics/tick_metrics.hpp"

#include <utility>

namespace haptic::server {
namespace {

// Bounds in seconds. The period is looked at around 1 ms; lateness from the few microseconds of an
// idle real-time host to the 20 ms of LOOP_LATE; ages by the levels of
// proto/README.md#staleness-and-gain (5..80, 100, 180 ms).
constexpr std::array<double, 13> kPeriods{0.0005,  0.0008,  0.0009, 0.00095, 0.00098,
                                          0.00102, 0.00105, 0.0011, 0.0012,  0.0015,
                                          0.002,   0.005,   0.02};
constexpr std::array<double, 13> kLateness{5e-6,  1e-5,  2e-5,  5e-5,  0.0001, 0.0002, 0.0005,
                                           0.001, 0.002, 0.005, 0.008, 0.01,   0.02};
constexpr std::array<double, 13> kAges{0.001, 0.002, 0.005, 0.01, 0.02, 0.03, 0.04,
                                       0.05,  0.08,  0.1,   0.13, 0.18, 0.5};
/// A board's samples: fine around the targets, 2 ms streaming and 4 ms at 500 Hz
/// (hw/README.md#the-board-device), and below half a millisecond, which is usual in a loop that they
/// pace.
constexpr std::array<double, 17> kSampleAges{5e-5,   0.0001,  0.0002, 0.0005, 0.001, 0.00125,
                                             0.0015, 0.00175, 0.002,  0.0025, 0.003, 0.0035,
                                             0.004,  0.005,   0.007,  0.01,   0.1};

template <std::size_t n>
void bump(std::array<std::uint64_t, n>& counts, std::uint32_t bits) {
  for (std::size_t i = 0; bits != 0; ++i, bits >>= 1U) counts[i] += bits & 1U;
}

}  // namespace

TickTotals::TickTotals()
    : period(kPeriods), lateness(kLateness), age(kAges), sample_age(kSampleAges) {}

void TickMetrics::on_record(const core::TickRecord& record) {
  const double seconds = core::seconds(record.beat.dt);
  const std::lock_guard lock(mutex_);
  if (record.beat.tick > 1) totals_.period.add(seconds);  // the first has none before it
  totals_.lateness.add(core::seconds(record.input.loop.lateness));
  const core::DeviceSample& sample = record.input.device.sample;
  if (sample.seq != 0) totals_.sample_age.add(core::seconds(record.input.now - sample.time));
  if (record.proxy.seq != 0) totals_.age.add(core::seconds(record.proxy.age));
  if (record.input.command.lease_held) {
    totals_.level_s[static_cast<std::size_t>(record.proxy.level) - 1] += seconds;
    count_carrier(record, seconds);
  }
  bump(totals_.limited, record.limiters().bits());
  bump(totals_.faults, record.faults().bits() & ~totals_.newest.faults().bits());
  totals_.lost += record.life.lost ? 1 : 0;
  totals_.newest = record;
}

void TickMetrics::count_carrier(const core::TickRecord& record, double seconds) {
  const Carrier carrier = carrier_();
  totals_.carrier_s[static_cast<std::size_t>(carrier)] += seconds;
  const std::uint32_t epoch = record.input.command.lease_epoch;
  const bool followed = carrier != Carrier::kNone && last_carrier_ != Carrier::kNone;
  if (epoch == carrier_epoch_ && followed && carrier != last_carrier_) ++totals_.carrier_changes;
  carrier_epoch_ = epoch;
  last_carrier_ = carrier;
}

TickTotals TickMetrics::totals() const {
  const std::lock_guard lock(mutex_);
  return totals_;
}

}  // namespace haptic::server
