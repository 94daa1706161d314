#include "server/metrics/tick_metrics.hpp"

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
/// (hw/README.md#the-board-device), and below half a millisecond, which is usual in a loop that
/// they pace.
constexpr std::array<double, 17> kSampleAges{5e-5,   0.0001,  0.0002, 0.0005, 0.001, 0.00125,
                                             0.0015, 0.00175, 0.002,  0.0025, 0.003, 0.0035,
                                             0.004,  0.005,   0.007,  0.01,   0.1};

template <std::size_t n>
void bump(std::array<std::uint64_t, n>& counts, std::uint32_t bits) {
  for (std::size_t i = 0; bits != 0; ++i, bits >>= 1U) counts[i] += bits & 1U;
}

void count_carrier(const StateRecord& state, double seconds, TickTotals& totals) {
  totals.carrier_s[static_cast<std::size_t>(state.carrier)] += seconds;
  const bool followed = state.carrier != Carrier::kNone && totals.last_carrier != Carrier::kNone;
  if (state.tenure == totals.carrier_tenure && followed && state.carrier != totals.last_carrier) {
    ++totals.carrier_changes;
  }
  totals.carrier_tenure = state.tenure;
  totals.last_carrier = state.carrier;
}

}  // namespace

TickTotals::TickTotals()
    : period(kPeriods), lateness(kLateness), age(kAges), sample_age(kSampleAges) {}

void TickMetrics::on_tick(std::size_t device, const StateRecord& state) {
  const double seconds = core::seconds(state.dt);
  const std::lock_guard lock(mutex_);
  TickTotals& totals = totals_.at(device);
  if (state.tick > 1) totals.period.add(seconds);  // the first has none before it
  totals.lateness.add(core::seconds(state.lateness));
  if (state.sample_seq != 0) totals.sample_age.add(core::seconds(state.sample_age));
  if (state.proxy_seq != 0) totals.age.add(core::seconds(state.proxy_age));
  if (state.lease_held) {
    totals.level_s[static_cast<std::size_t>(state.staleness) - 1] += seconds;
    count_carrier(state, seconds, totals);
  }
  bump(totals.limited, state.limiters.bits());
  bump(totals.faults, state.faults.bits() & ~totals.newest.faults.bits());
  totals.lost += state.lost ? 1 : 0;
  totals.newest = state;
}

TickTotals TickMetrics::totals(std::size_t device) const {
  const std::lock_guard lock(mutex_);
  return totals_.at(device);
}

}  // namespace haptic::server
