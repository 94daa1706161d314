/// publish() and publish_pose(): the one place where samples get their numbers.

#include <algorithm>

#include "convert.hpp"
#include "haptic/client/planes.hpp"
#include "remote_session.hpp"
#include "udp_carrier.hpp"

namespace haptic::client {

namespace {

constexpr v1::ProxyMode kFree = v1::PROXY_MODE_FREE;

template <typename Duration>
std::uint32_t microseconds(Duration duration) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(duration);
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(us.count(), 0, 0xffffffffLL));
}

}  // namespace

/// `fill` completes the sample under mutex_, given its number.
template <typename Fill>
void RemoteSession::publish_in_order(v1::SessionRequest& request, Fill fill) {
  const std::lock_guard in_order(publish_mutex_);
  std::shared_ptr<Stream> stream;
  std::shared_ptr<UdpCarrier> udp;
  {
    const std::lock_guard lock(mutex_);
    fill(++statistics_.published);
    if (reconnection_.open()) {
      was_free_ = was_free_ || (request.has_proxy() && request.proxy().mode() == kFree);
      stream = stream_;
      udp = udp_;
    }
    if (resumable() && reconnection_.state() == Reconnection::State::kLeaseLost) {
      // Only a new session controls the device. It begins with this sample and not before, so that
      // a silent client does not hold the device.
      reconnection_.ended(
          {ErrorReason::kClosed, "the lease is over: it had expired, or was preempted"});
      work_.notify_all();
    }
  }
  if (request.has_proxy() && send_by_udp(request.proxy(), udp.get())) return;
  if (stream) stream->send(std::move(request));
}

void RemoteSession::publish(Proxy proxy) noexcept {
  try {
    v1::SessionRequest request;
    v1::ProxySample& sample = *request.mutable_proxy();
    sample.set_valid_for_us(microseconds(proxy.valid_for));
    sample.mutable_position()->Add(proxy.position.begin(), proxy.position.end());
    publish_in_order(request, [&](std::uint64_t number) {
      const auto now = Clock::now();
      // The state that the user was given, not one that arrived while the simulation computed.
      const NewestState::Given& given = states_.given();
      const std::uint64_t used = proxy.device_seq_used != 0 ? proxy.device_seq_used : given.seq;
      to_contacts(proxy);
      statistics_.planes_left_out +=
          keep_deepest(device_.coordinates, proxy.position, given.x_probe, proxy.planes);
      sample.set_source_time_ns(now.time_since_epoch().count());
      sample.set_seq(number);
      round_trip_.published(number, now);
      sample.set_mode(static_cast<v1::ProxyMode>(proxy.mode));
      for (const Plane& plane : proxy.planes) write(plane, *sample.add_planes());
      sample.set_device_seq_used(used);
      if (used != 0 && used == given.seq) sample.set_hold_us(microseconds(now - given.received));
    });
  } catch (...) {  // NOLINT(bugprone-empty-catch): out of memory loses this sample, not the caller
  }
}

void RemoteSession::publish_pose(const Pose& pose) noexcept {
  try {
    v1::SessionRequest request;
    v1::TrackerSample& sample = *request.mutable_tracker();
    sample.set_valid_for_us(microseconds(pose.valid_for));
    sample.mutable_position()->Add(pose.position.begin(), pose.position.end());
    sample.mutable_orientation()->Add(pose.orientation.begin(), pose.orientation.end());
    publish_in_order(request, [&](std::uint64_t number) { sample.set_seq(number); });
  } catch (...) {  // NOLINT(bugprone-empty-catch): out of memory loses this pose, not the caller
  }
}

/// Under mutex_. A proxy that was computed from an older state stays held: its probe is not known.
/// So does one before the first free one: the probe may be inside an object, and a surface on the
/// wrong side of it would pull the probe through.
void RemoteSession::to_contacts(Proxy& proxy) {
  const NewestState::Given& given = states_.given();
  if (!options_.derive_planes) return;
  if (proxy.mode == Mode::kFree) estimator_.free();
  if (!was_free_ || proxy.mode != Mode::kHeld || given.x_probe.empty()) return;
  if (proxy.device_seq_used != 0 && proxy.device_seq_used != given.seq) return;
  proxy.mode = Mode::kPlanes;
  proxy.planes = estimator_.contacts(proxy.position, given.x_probe);
}

}  // namespace haptic::client
