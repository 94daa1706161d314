#include "server/ingress/ingress.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace haptic::server {
namespace {

std::string coordinate(int i, double value) {
  char text[64];
  std::snprintf(text, sizeof text, "position[%d] = %.6g", i, value);
  return text;
}

/// Below this a normal is none: its square would leave the range of a double.
constexpr double kSmallestNormal = 1e-100;

/// Numbers below the normal range cost a hundred times a normal one in every product of the loop.
double flushed(double value) noexcept {
  return std::fpclassify(value) == FP_SUBNORMAL ? 0.0 : value;
}

}  // namespace

IngressCounters& IngressCounters::operator+=(const IngressCounters& other) noexcept {
  accepted += other.accepted;
  backlog += other.backlog;
  old_sequence += other.old_sequence;
  old_epoch += other.old_epoch;
  wrong_size += other.wrong_size;
  not_finite += other.not_finite;
  out_of_bounds += other.out_of_bounds;
  unknown_mode += other.unknown_mode;
  bad_plane += other.bad_plane;
  return *this;
}

Ingress::Ingress(core::Mailbox<core::ProxySnapshot>& mailbox, int n_x)
    : mailbox_(mailbox), n_x_(n_x) {
  newest_.x.resize(0);
}

void Ingress::begin_lease(std::uint32_t epoch, double nominal_rate_hz, core::Duration hold_end,
                          std::uint32_t grant) {
  const std::lock_guard lock(mutex_);
  last_refusal_.clear();
  open_ = true;
  epoch_ = epoch;
  hold_end_ = hold_end;
  before_ += counters_;
  counters_ = {};
  last_arrival_ = {};
  carrier_ = Carrier::kNone;
  backlog_ = BacklogRule(std::chrono::duration_cast<core::Duration>(
      std::chrono::duration<double>(1.0 / nominal_rate_hz)));
  newest_ = {};
  newest_.epoch = grant == 0 ? epoch : grant;
  mailbox_.publish(newest_);
}

void Ingress::renew_lease(std::uint32_t epoch) {
  const std::lock_guard lock(mutex_);
  epoch_ = epoch;
}

void Ingress::end_lease() {
  const std::lock_guard lock(mutex_);
  open_ = false;
}

std::string Ingress::last_refusal() const {
  const std::lock_guard lock(mutex_);
  return last_refusal_;
}

IngressVerdict Ingress::accept(const ProxyCandidate& candidate, core::TimePoint arrival,
                               std::string* why) {
  const std::lock_guard lock(mutex_);
  const IngressVerdict refused = check(candidate, why);
  if (refused != IngressVerdict::kAccepted) return refused;
  last_refusal_.clear();
  const BacklogRule::Answer age = backlog_.step(arrival);
  store(candidate, age, arrival);
  ++(age.backlog ? counters_.backlog : counters_.accepted);
  return age.backlog ? IngressVerdict::kBacklog : IngressVerdict::kAccepted;
}

IngressVerdict Ingress::check(const ProxyCandidate& candidate, std::string* why) {
  const auto refuse = [&](IngressVerdict verdict, std::uint64_t& counter, auto sentence) {
    ++counter;
    std::string text = sentence();
    if (why != nullptr) *why = text;
    if (open_ && candidate.epoch == epoch_) last_refusal_ = std::move(text);
    return verdict;
  };
  if (!open_ || candidate.epoch != epoch_) {
    return refuse(IngressVerdict::kOldEpoch, counters_.old_epoch, [&] {
      return "lease epoch " + std::to_string(candidate.epoch) +
             (open_ ? ": the lease is at epoch " + std::to_string(epoch_)
                    : ": nobody holds the lease");
    });
  }
  if (candidate.mode == core::ProxyMode::kNone) {
    return refuse(IngressVerdict::kUnknownMode, counters_.unknown_mode,
                  [] { return std::string("mode: must be HELD, FREE or PLANES"); });
  }
  const bool may_be_empty = candidate.mode == core::ProxyMode::kFree;
  if (candidate.position_size != n_x_ && !(may_be_empty && candidate.position_size == 0)) {
    return refuse(IngressVerdict::kWrongSize, counters_.wrong_size, [&] {
      return "position has " + std::to_string(candidate.position_size) + " values: must have " +
             std::to_string(n_x_) + ", one per virtual coordinate";
    });
  }
  for (int i = 0; i < candidate.position_size; ++i) {
    const double value = candidate.position[i];
    if (!std::isfinite(value)) {
      return refuse(IngressVerdict::kNotFinite, counters_.not_finite,
                    [&] { return coordinate(i, value) + ": must be finite"; });
    }
    if (std::abs(value) > kLargestCoordinate) {
      return refuse(IngressVerdict::kOutOfBounds, counters_.out_of_bounds,
                    [&] { return coordinate(i, value) + ": must lie within +-1000"; });
    }
  }
  if (candidate.plane_count > 0) {
    std::string wrong = wrong_plane(candidate);
    if (!wrong.empty()) {
      return refuse(IngressVerdict::kBadPlane, counters_.bad_plane,
                    [&] { return std::move(wrong); });
    }
  }
  if (candidate.seq <= newest_.seq) {
    return refuse(IngressVerdict::kOldSequence, counters_.old_sequence, [&] {
      return "seq = " + std::to_string(candidate.seq) + ": must be above " +
             std::to_string(newest_.seq);
    });
  }
  return IngressVerdict::kAccepted;
}

std::string Ingress::wrong_plane(const ProxyCandidate& candidate) const {
  const auto text = [](int plane, const std::string& field, double value, const std::string& why) {
    char number[32];
    std::snprintf(number, sizeof number, "%.6g", value);
    return "planes[" + std::to_string(plane) + "]." + field + " = " + number + ": " + why;
  };
  if (candidate.mode != core::ProxyMode::kPlanes) return "planes: only in mode PLANES";
  if (candidate.plane_count > core::kMaxPlanes) {
    return "planes has " + std::to_string(candidate.plane_count) + " entries: at most " +
           std::to_string(core::kMaxPlanes);
  }
  for (int p = 0; p < candidate.plane_count; ++p) {
    const PlaneCandidate& plane = candidate.planes[static_cast<std::size_t>(p)];
    if (plane.normal_size != n_x_) {
      return "planes[" + std::to_string(p) + "].normal has " + std::to_string(plane.normal_size) +
             " values: must have " + std::to_string(n_x_) + ", one per virtual coordinate";
    }
    double largest = 0.0;
    for (int i = 0; i < n_x_; ++i) {
      const double value = plane.normal[i];
      if (!(std::abs(value) <= kLargestNormal)) {
        return text(p, "normal[" + std::to_string(i) + "]", value, "must lie within +-1e6");
      }
      largest = std::max(largest, std::abs(value));
    }
    if (!(largest >= kSmallestNormal)) return text(p, "normal", largest, "must have a direction");
    if (!(std::abs(plane.offset) <= kLargestOffset)) {
      return text(p, "offset", plane.offset, "must lie within +-1e9");
    }
  }
  return {};
}

void Ingress::store(const ProxyCandidate& candidate, BacklogRule::Answer age,
                    core::TimePoint arrival) {
  // The stream's health counts what keeps time; a gap is one of fresh samples, not of arrivals.
  if (!age.backlog) {
    const bool gap = newest_.mode == core::ProxyMode::kNone || arrival - newest_.born > hold_end_;
    if (gap) {
      newest_.gapless_since = arrival;
      newest_.gapless_samples = 0;
    }
    ++newest_.gapless_samples;
  }
  newest_.mode = candidate.mode;
  newest_.seq = candidate.seq;
  newest_.born = std::min(age.born, candidate.left.value_or(age.born));
  newest_.valid_for = candidate.valid_for;
  newest_.x.resize(candidate.position_size);
  for (int i = 0; i < candidate.position_size; ++i) newest_.x[i] = flushed(candidate.position[i]);
  newest_.planes.normals.resize(n_x_, candidate.plane_count);
  newest_.planes.offsets.resize(candidate.plane_count);
  for (int p = 0; p < candidate.plane_count; ++p) {
    const PlaneCandidate& plane = candidate.planes[static_cast<std::size_t>(p)];
    for (int i = 0; i < n_x_; ++i) newest_.planes.normals(i, p) = flushed(plane.normal[i]);
    newest_.planes.offsets[p] = flushed(plane.offset);
  }
  last_arrival_ = arrival;
  carrier_ = candidate.carrier;
  carried_[candidate.seq % carried_.size()] = {candidate.seq, newest_.born, candidate.carrier};
  mailbox_.publish(newest_);
}

Carrier Ingress::carrier_of(std::uint64_t seq, core::TimePoint born) const noexcept {
  const std::lock_guard lock(mutex_);
  const Carried& carried = carried_[seq % carried_.size()];
  return carried.seq == seq && carried.born == born ? carried.carrier : Carrier::kNone;
}

std::uint64_t Ingress::newest_seq() const {
  const std::lock_guard lock(mutex_);
  return newest_.seq;
}

IngressCounters Ingress::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

IngressCounters Ingress::totals() const {
  const std::lock_guard lock(mutex_);
  IngressCounters all = before_;
  return all += counters_;
}

core::TimePoint Ingress::last_accepted() const {
  const std::lock_guard lock(mutex_);
  return last_arrival_;
}

}  // namespace haptic::server
