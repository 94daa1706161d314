#include "server/owner/telemetry/tick_metrics.hpp"

namespace haptic::server {
namespace {

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
  bump(totals.faults, state.faults.bits() & ~totals.active.bits());
  totals.lost += state.lost ? 1 : 0;
  totals.state = state.state;
  totals.gain = state.gain;
  totals.error_bound = state.error_bound;
  totals.active = state.faults;
}

TickTotals TickMetrics::totals(std::size_t device) const {
  const std::lock_guard lock(mutex_);
  return totals_.at(device);
}

}  // namespace haptic::server
