#include "server/owner/ingress/ingress.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "server/owner/ingress/refused.hpp"

namespace haptic::server {
namespace {

/// Time over which the rate of a stream is counted.
constexpr core::Duration kCounted{std::chrono::milliseconds(500)};

}  // namespace

/// Without a branch, which the zeros among the numbers of a normal would mislead.
double flushed(double value) noexcept {
  constexpr auto kSmallest = std::bit_cast<std::uint64_t>(std::numeric_limits<double>::min());
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const std::uint64_t twice = 2 * bits;  // without the sign
  // 0 - 1 is the largest number.
  return std::bit_cast<double>(twice - 1 < 2 * kSmallest - 1 ? 0 : bits);
}

BacklogRule::BacklogRule(core::Duration nominal_period)
    : interval_(nominal_period / 2), tolerance_(std::max(interval_, kShortestFreshEnd)) {}

BacklogRule::Answer BacklogRule::step(core::TimePoint arrival) noexcept {
  const core::Duration pause = arrival - last_arrival_;
  const bool ran_dry = first_ || pause >= interval_;
  if (first_) {
    // Nothing is known of this stream's past: a burst at its very beginning has no age to fall back
    // to but its own.
    before_burst_ = arrival;
    due_ = arrival;
  } else if (ran_dry) {
    before_burst_ = pause >= 2 * interval_ ? last_arrival_ : born_;
    if (backlog_) due_ = arrival;
    backlog_ = false;
  }
  first_ = false;
  last_arrival_ = arrival;
  ++count_;
  if (const core::Duration time = arrival - counted_from_; time >= kCounted) {
    comes_hz_ = std::round(count_ / core::seconds(time));
    counted_from_ = arrival;
    count_ = 0;
  }

  // A bucket that twice the nominal rate empties: `due_` runs ahead of the arrivals in a burst.
  if (!backlog_ && arrival < due_ - tolerance_) backlog_ = true;
  if (backlog_) {
    born_ = before_burst_;
  } else {
    due_ = std::max(due_, arrival) + interval_;
    born_ = arrival;
  }
  return {backlog_, born_};
}

core::StreamRate BacklogRule::too_fast() const noexcept {
  const double announced = 0.5 / core::seconds(interval_);
  return backlog_ && comes_hz_ > 2.0 * announced ? core::StreamRate{comes_hz_, announced}
                                                 : core::StreamRate{};
}

Ingress::Ingress(core::Mailbox<core::ProxySnapshot>& mailbox, int n_x)
    : mailbox_(mailbox), n_x_(static_cast<std::uint32_t>(n_x)) {}

void Ingress::begin_lease(std::uint32_t epoch, double nominal_rate_hz, core::Duration hold_end,
                          std::uint32_t tenure) {
  last_refusal_ = {};
  open_ = true;
  epoch_ = epoch;
  hold_end_ = hold_end;
  last_arrival_ = {};
  carrier_ = Carrier::kNone;
  backlog_ = BacklogRule(std::chrono::duration_cast<core::Duration>(
      std::chrono::duration<double>(1.0 / nominal_rate_hz)));
  newest_ = {.tenure = tenure == 0 ? epoch : tenure};
  core::ProxySnapshot none;
  none.tenure = newest_.tenure;
  mailbox_.publish(none);
}

void Ingress::renew_lease(std::uint32_t epoch) {
  epoch_ = epoch;
}

void Ingress::end_lease() {
  open_ = false;
}

Verdict Ingress::accept(const ProxySample& sample) {
  Verdict verdict = check(sample);
  if (verdict.used()) {
    last_refusal_ = {};
    const BacklogRule::Answer age = backlog_.step(sample.arrival);
    store(sample, age);
    if (age.backlog) verdict.verdict = IngressVerdict::kBacklog;
  } else if (open_ && sample.epoch == epoch_) {
    last_refusal_ = verdict.why;
  }
  ++counters_.count[static_cast<std::size_t>(verdict.verdict)];
  return verdict;
}

Verdict Ingress::check(const ProxySample& sample) const {
  if (!open_) {
    return refused(IngressVerdict::kOldEpoch, "lease epoch {}: no session holds the lease",
                   sample.epoch);
  }
  if (sample.epoch != epoch_) {
    return refused(IngressVerdict::kOldEpoch, "lease epoch {}: the lease is at epoch {}",
                   sample.epoch, epoch_);
  }
  if (sample.mode == core::ProxyMode::kNone) {
    return refused(IngressVerdict::kUnknownMode, "mode: must be HELD, FREE or PLANES");
  }
  const bool may_be_empty = sample.mode == core::ProxyMode::kFree;
  if (sample.position.count != n_x_ && !(may_be_empty && sample.position.count == 0)) {
    return refused(IngressVerdict::kWrongSize,
                   "position has {} values: must have {}, one per virtual coordinate",
                   sample.position.count, n_x_);
  }
  for (std::size_t i = 0; i < sample.position.count; ++i) {
    const double value = sample.position.value[i];
    if (!std::isfinite(value)) {
      return refused(IngressVerdict::kNotFinite, "position[{}] = {:.6g}: must be finite", i, value);
    }
    if (std::abs(value) > kLargestCoordinate) {
      return refused(IngressVerdict::kOutOfBounds, "position[{}] = {:.6g}: must lie within +-1000",
                     i, value);
    }
  }
  if (sample.plane_count > 0) {
    if (const auto wrong = check_planes(sample)) return *wrong;
  }
  if (sample.seq <= newest_.seq) {
    return refused(IngressVerdict::kOldSequence, "seq = {}: must be above {}", sample.seq,
                   newest_.seq);
  }
  return {};
}

void Ingress::store(const ProxySample& sample, const BacklogRule::Answer& age) {
  const core::TimePoint arrival = sample.arrival;
  // The stream's health counts what keeps time; a gap is one of fresh samples, not of arrivals.
  if (!age.backlog) {
    const bool gap = newest_.mode == core::ProxyMode::kNone || arrival - newest_.born > hold_end_;
    if (gap) {
      newest_.gapless_since = arrival;
      newest_.gapless_samples = 0;
    }
    ++newest_.gapless_samples;
  }
  newest_.too_fast = backlog_.too_fast();
  newest_.mode = sample.mode;
  newest_.seq = sample.seq;
  const Departure left = sample.left.value_or(Departure{age.born, age.born});
  newest_.born = std::min(age.born, left.latest);
  publish(sample, std::min(arrival, left.likely));
  last_arrival_ = arrival;
  carrier_ = sample.carrier;
  carried_[sample.seq % carried_.size()] = {sample.seq, newest_.born, sample.carrier};
}

void Ingress::publish(const ProxySample& sample, core::TimePoint computed) {
  core::ProxySnapshot& next = mailbox_.draft();
  next.mode = newest_.mode;
  next.tenure = newest_.tenure;
  next.seq = newest_.seq;
  next.born = newest_.born;
  next.computed = computed;
  next.valid_for = sample.valid_for;
  next.x.resize(sample.position.count);
  std::transform(sample.position.begin(), sample.position.end(), next.x.data(), flushed);
  write_planes(sample, next);
  next.gapless_since = newest_.gapless_since;
  next.gapless_samples = newest_.gapless_samples;
  next.too_fast = newest_.too_fast;
  mailbox_.publish();
}

Carrier Ingress::carrier_of(std::uint64_t seq, core::TimePoint born) const noexcept {
  const Carried& carried = carried_[seq % carried_.size()];
  return carried.seq == seq && carried.born == born ? carried.carrier : Carrier::kNone;
}

}  // namespace haptic::server
