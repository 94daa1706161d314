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
    const auto now = Clock::now();
    sample.set_source_time_ns(now.time_since_epoch().count());
    sample.set_valid_for_us(microseconds(proxy.valid_for));
    sample.mutable_position()->Add(proxy.position.begin(), proxy.position.end());
    sample.set_mode(proxy.mode == Mode::kHeld ? v1::PROXY_MODE_HELD : v1::PROXY_MODE_FREE);
    {
      const std::lock_guard lock(mutex_);
      ++statistics_.published;
      sample.set_seq(++seq_);
      if (proxy.mode != last_mode_) ++mode_epoch_;
      last_mode_ = proxy.mode;
      sample.set_mode_epoch(mode_epoch_);
      // The state that the user was given, not one that arrived while the simulation computed.
      const std::uint64_t used = proxy.device_seq_used != 0 ? proxy.device_seq_used : handed_seq_;
      sample.set_device_seq_used(used);
      if (used != 0 && used == handed_seq_)
        sample.set_hold_us(microseconds(now - handed_received_));
      if (phase_ == Phase::kOpen) stream = stream_;
    }
    if (stream) stream->send(sample);
  } catch (...) {  // NOLINT(bugprone-empty-catch): out of memory loses this sample, not the caller
  }
}

}  // namespace haptic::client
