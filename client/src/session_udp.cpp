/// The session's UDP path: samples up and states down beside the stream, which is its fallback.

#include "session_impl.hpp"

namespace haptic::client {

void Session::Impl::start_udp(Lock& lock) {
  if (options_.carriers == Carriers::kGrpcOnly) return;  // whatever the server offers
  const bool required = options_.carriers == Carriers::kUdpOnly;
  if (!opened_.has_udp()) {
    if (!required) return;
    const std::string why = opened_.udp_refused();
    const std::shared_ptr<Stream> stream = std::move(stream_);
    phase_ = Phase::kDone;
    lock.unlock();
    stream->end();
    throw ClientError(ErrorReason::kInvalidArgument, "the server offers no UDP path: " + why);
  }
  const v1::UdpPath offer = opened_.udp();
  // What the path's silence is measured by: an observer hears states, at the rate it asked for.
  const double states = options_.state_rate_hz > 0.0 ? options_.state_rate_hz : 1000.0;
  const double rate = options_.observer ? states : options_.nominal_rate_hz;
  const auto period = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / rate));
  lock.unlock();
  auto path = std::make_shared<UdpPath>(offer, udp_host_, period, *this);
  lock.lock();
  udp_ = std::move(path);  // if the stream has ended by now, the worker ends this too
}

void Session::Impl::stop_udp(Lock& lock) {
  const std::shared_ptr<UdpPath> path = std::move(udp_);
  udp_.reset();
  if (!path) return;
  lock.unlock();  // its thread may be waiting for our locks
  path->stop();
  lock.lock();
}

bool Session::Impl::send_by_udp(const v1::ProxySample& sample, UdpPath* path) {
  const ByUdp sent = path != nullptr ? path->send(sample) : ByUdp::kNo;
  const bool alone = sent == ByUdp::kYes || options_.carriers == Carriers::kUdpOnly;
  if (sent != ByUdp::kNo && alone) {  // else the stream counts it
    const std::lock_guard lock(mutex_);
    ++statistics_.sent;
  }
  return alone;
}

void Session::Impl::on_udp_state(const v1::DeviceState& state) {
  {
    const std::lock_guard lock(mutex_);
    if (phase_ != Phase::kOpen) return;
    received(state);
    changed_.notify_all();
  }
  deliver();
}

/// The newest sample may be lost, and a simulation that holds still would not send another soon.
void Session::Impl::on_udp_fallback(const v1::ProxySample& newest) {
  if (newest.seq() == 0 || options_.carriers == Carriers::kUdpOnly) return;
  const std::lock_guard in_order(publish_mutex_);
  std::shared_ptr<Stream> stream;
  {
    const std::lock_guard lock(mutex_);
    if (phase_ == Phase::kOpen && newest.seq() == seq_) stream = stream_;
  }
  if (stream) stream->send(newest);
}

std::optional<UdpLink> Session::Impl::udp_link() const {
  std::shared_ptr<UdpPath> path;
  {
    const std::lock_guard lock(mutex_);
    path = udp_;
  }
  if (!path) return std::nullopt;
  const UdpFigures figures = path->figures();
  return UdpLink{figures.in_use, figures.round_trip, figures.received, figures.lost};
}

}  // namespace haptic::client
