#include "server/owner/telemetry/tick_metrics.hpp"

namespace haptic::server {
namespace {

template <std::size_t n>
void bump(std::array<std::uint64_t, n>& counts, std::uint32_t bits) {
  for (std::size_t i = 0; bits != 0; ++i, bits >>= 1U) counts[i] += bits & 1U;
}

void count_carrier(const TickTold& told, double seconds, TickTotals& totals) {
  totals.carrier_s[static_cast<std::size_t>(told.carrier)] += seconds;
  const std::uint32_t tenure = told.record.input.command.tenure;
  const bool followed = told.carrier != Carrier::kNone && totals.last_carrier != Carrier::kNone;
  if (tenure == totals.carrier_tenure && followed && told.carrier != totals.last_carrier) {
    ++totals.carrier_changes;
  }
  totals.carrier_tenure = tenure;
  totals.last_carrier = told.carrier;
}

}  // namespace

void TickMetrics::count(std::size_t device, const TickTold& told) {
  const core::TickRecord& record = told.record;
  const core::DeviceSample& sample = record.input.device.sample;
  const double seconds = core::seconds(record.beat.dt);
  const std::lock_guard lock(mutex_);
  TickTotals& totals = totals_.at(device);
  if (record.beat.tick > 1) totals.period.add(seconds);  // the first has none before it
  totals.lateness.add(core::seconds(record.input.loop.lateness));
  if (sample.seq != 0) totals.sample_age.add(core::seconds(record.input.now - sample.time));
  if (record.proxy.seq != 0) totals.age.add(core::seconds(record.proxy.age));
  if (record.input.command.lease_held) {
    totals.level_s[static_cast<std::size_t>(record.proxy.level) - 1] += seconds;
    count_carrier(told, seconds, totals);
  }
  bump(totals.limited, record.limiters().bits());
  bump(totals.faults, record.faults().bits() & ~totals.active.bits());
  totals.lost += record.life.lost ? 1 : 0;
  totals.state = record.life.state;
  totals.gain = record.life.gain;
  totals.error_bound = values(record.effort.error_bound);
  totals.active = record.faults();
}

TickTotals TickMetrics::totals(std::size_t device) const {
  const std::lock_guard lock(mutex_);
  return totals_.at(device);
}

}  // namespace haptic::server
