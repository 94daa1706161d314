/// The session's UDP carrier: samples up and states down next to the stream, which is its fallback.

#include "remote_session.hpp"
#include "udp_carrier.hpp"

namespace haptic::client {

void RemoteSession::start_udp(Lock& lock) {
  if (options_.carriers == Carriers::kGrpcOnly) return;  // whatever the server offers
  if (!opened_.has_udp()) {
    if (options_.carriers != Carriers::kUdpOnly) return;
    throw ClientError(ErrorReason::kInvalidArgument,
                      "the server offers no UDP path: " + opened_.udp_refused());
  }
  const v1::UdpPath offer = opened_.udp();
  // An observer hears states, at the rate it asked for; the others send samples.
  const double states = options_.state_rate_hz > 0.0 ? options_.state_rate_hz : 1000.0;
  const double rate = options_.observer ? states : options_.nominal_rate_hz;
  const auto period = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / rate));
  lock.unlock();
  auto udp = std::make_shared<UdpCarrier>(offer, address_, period, *this);
  lock.lock();
  udp_ = std::move(udp);  // if the stream has ended by now, the worker ends this too
}

void RemoteSession::stop_udp(Lock& lock) {
  const std::shared_ptr<UdpCarrier> udp = std::exchange(udp_, nullptr);
  if (!udp) return;
  lock.unlock();  // its thread may be waiting for our locks
  udp->stop();
  lock.lock();
}

bool RemoteSession::send_by_udp(const v1::ProxySample& sample, UdpCarrier* udp) {
  using Sent = UdpCarrier::Sent;
  const Sent sent = udp != nullptr ? udp->send(sample) : Sent::kNo;
  const bool alone = sent == Sent::kYes || options_.carriers == Carriers::kUdpOnly;
  if (sent != Sent::kNo && alone) {  // else the stream counts it
    const std::lock_guard lock(mutex_);
    ++statistics_.sent;
  }
  return alone;
}

void RemoteSession::on_udp_state(const v1::DeviceState& state) {
  {
    const std::lock_guard lock(mutex_);
    if (!reconnection_.open()) return;
    received(state);
    changed_.notify_all();
  }
  deliver();
}

/// A simulation that holds still would not send another sample soon.
void RemoteSession::on_udp_late(const v1::ProxySample& newest) {
  if (newest.seq() == 0 || options_.carriers == Carriers::kUdpOnly) return;
  const std::lock_guard in_order(publish_mutex_);
  std::shared_ptr<Stream> stream;
  {
    const std::lock_guard lock(mutex_);
    if (reconnection_.open() && newest.seq() == statistics_.published) stream = stream_;
  }
  v1::SessionRequest request;
  *request.mutable_proxy() = newest;
  if (stream) stream->send(std::move(request));
}

std::optional<UdpLink> RemoteSession::udp_link() const {
  std::shared_ptr<UdpCarrier> udp;
  {
    const std::lock_guard lock(mutex_);
    udp = udp_;
  }
  if (!udp) return std::nullopt;
  return udp->figures();
}

}  // namespace haptic::client
