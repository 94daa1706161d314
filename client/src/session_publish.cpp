/// publish(): the one place where sequence numbers are made.

#include <algorithm>

#include "session_impl.hpp"

namespace haptic::client {

namespace {

template <typename Duration>
std::uint32_t microseconds(Duration duration) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(duration);
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(us.count(), 0, 0xffffffffLL));
}

}  // namespace

void Session::Impl::publish(Proxy proxy) noexcept {
  try {
    const std::lock_guard in_order(publish_mutex_);
    v1::ProxySample sample;
    std::shared_ptr<Stream> stream;
    std::shared_ptr<UdpPath> udp;
    const auto now = Clock::now();
    sample.set_source_time_ns(now.time_since_epoch().count());
    sample.set_valid_for_us(microseconds(proxy.valid_for));
    sample.mutable_position()->Add(proxy.position.begin(), proxy.position.end());
    {
      const std::lock_guard lock(mutex_);
      to_planes(proxy);
      ++statistics_.published;
      sample.set_seq(++seq_);
      if (proxy.mode != last_mode_) ++mode_epoch_;
      last_mode_ = proxy.mode;
      sample.set_mode_epoch(mode_epoch_);
      sample.set_mode(static_cast<v1::ProxyMode>(proxy.mode));
      for (const Plane& plane : proxy.planes) {
        v1::Plane& sent = *sample.add_planes();
        sent.mutable_normal()->Add(plane.normal.begin(), plane.normal.end());
        sent.set_offset(plane.offset);
      }
      // The state that the user was given, not one that arrived while the simulation computed.
      const std::uint64_t used = proxy.device_seq_used != 0 ? proxy.device_seq_used : handed_seq_;
      sample.set_device_seq_used(used);
      if (used != 0 && used == handed_seq_)
        sample.set_hold_us(microseconds(now - handed_received_));
      if (phase_ == Phase::kOpen) {
        stream = stream_;
        if (!closing_) udp = udp_;
      }
      if (stream && lease_lost_ && options_.reconnect == Reconnect::kWithBackoff) leave_for_lease();
    }
    if (send_by_udp(sample, udp.get())) return;
    if (stream) stream->send(sample);
  } catch (...) {  // NOLINT(bugprone-empty-catch): out of memory loses this sample, not the caller
  }
}

void Session::Impl::publish_pose(const Pose& pose) noexcept {
  try {
    const std::lock_guard in_order(publish_mutex_);
    v1::TrackerSample sample;
    sample.set_valid_for_us(microseconds(pose.valid_for));
    sample.mutable_position()->Add(pose.position.begin(), pose.position.end());
    sample.mutable_orientation()->Add(pose.orientation.begin(), pose.orientation.end());
    std::shared_ptr<Stream> stream;
    {
      const std::lock_guard lock(mutex_);
      ++statistics_.published;
      sample.set_seq(++seq_);
      if (phase_ == Phase::kOpen) stream = stream_;
    }
    if (stream) stream->send(sample);
  } catch (...) {  // NOLINT(bugprone-empty-catch): out of memory loses this pose, not the caller
  }
}

/// Under mutex_. A proxy of a state that the user no longer holds stays held: its probe is not known.
void Session::Impl::to_planes(Proxy& proxy) const {
  if (!options_.derive_planes || proxy.mode != Mode::kHeld || handed_x_probe_.empty()) return;
  if (proxy.device_seq_used != 0 && proxy.device_seq_used != handed_seq_) return;
  proxy.mode = Mode::kPlanes;
  proxy.planes =
      derive_planes(device_.coordinates, proxy.position, handed_x_probe_, options_.blocks);
}

/// A simulation that was silent for the lease time and speaks again: its stream only observes, a new
/// one controls. Opened by the next sample and not before, lest a silent client holds the device.
void Session::Impl::leave_for_lease() {
  end_ = {grpc::StatusCode::ABORTED, "the lease is over: it had expired, or was preempted"};
  end_pending_ = true;
  phase_ = Phase::kDone;
  lease_lost_ = false;
  work_.notify_all();
}

}  // namespace haptic::client
