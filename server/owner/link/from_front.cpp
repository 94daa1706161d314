#include "server/owner/link/from_front.hpp"

#include <algorithm>

#include "haptic/wire/printable.hpp"

namespace haptic::server {
namespace {

/// The wire has 32 bits of microseconds for a sample, and a day for the limits of a lease
/// (front/messages.cpp).
constexpr core::Duration kLongestValidity = std::chrono::microseconds(0xFFFF'FFFF);
constexpr core::Duration kLongestLimit = std::chrono::hours(24);

core::Duration validity(core::Duration said) noexcept {
  return std::clamp(said, core::Duration::zero(), kLongestValidity);
}

void bound(Maybe<core::Duration>& limit) noexcept {
  if (limit) limit = std::clamp(*limit, -kLongestLimit, kLongestLimit);
}

}  // namespace

core::TimePoint ArrivalOrder::in_order(core::TimePoint said, core::TimePoint now) noexcept {
  newest_ = std::clamp(said, std::min(newest_, now), now);
  return newest_;
}

void make_harmless(ProxySample& sample, core::TimePoint arrival) noexcept {
  sample.arrival = arrival;
  sample.valid_for = validity(sample.valid_for);
  if (sample.left) {
    const Departure left = *sample.left;
    sample.left = Departure{std::max(left.likely, {}), std::max(left.latest, {})};
  }
  if (sample.mode > core::ProxyMode::kPlanes) sample.mode = core::ProxyMode::kNone;
  const bool known = sample.carrier == Carrier::kUdp || sample.carrier == Carrier::kWebSocket;
  if (!known) sample.carrier = Carrier::kGrpc;
}

void make_harmless(PoseSample& sample, core::TimePoint arrival) noexcept {
  sample.arrival = arrival;
  sample.valid_for = validity(sample.valid_for);
}

void make_harmless(StopAhead& stop) {
  stop.why = wire::printable(stop.why.view());
}

bool make_harmless(Request& request, core::TimePoint now) {
  if (request.kind > Request::Kind::kCancel) return false;
  request.text = wire::printable(request.text.view());
  request.lease.client_name = wire::printable(request.lease.client_name.view());
  request.local = false;
  request.time = now;
  LeaseRequest& lease = request.lease;
  lease.priority = std::clamp(lease.priority, Priority::kTest, Priority::kOperator);
  bound(lease.fresh_end);
  bound(lease.hold_end);
  bound(lease.fade_end);
  const auto& renderer = request.settings.renderer;
  return !renderer ||
         (*renderer >= core::RendererKind::kStandard && *renderer <= core::kRenderers.back());
}

}  // namespace haptic::server
