#include "server/front/udp/server_path.hpp"

#include <utility>

#include "server/front/net/wire_time.hpp"

namespace haptic::server {

ServerPath::ServerPath(wire::PathEndSetup setup, std::weak_ptr<UdpSink> sink)
    : end_(std::move(setup)), sink_(std::move(sink)) {}

bool ServerPath::send_state(wire::ConstBytes state) {
  const std::lock_guard lock(mutex_);
  return end_.send(state);
}

wire::Rejection ServerPath::receive(wire::ConstBytes datagram, const wire::PeerAddress& from,
                                    core::TimePoint arrival) {
  wire::Received received;
  {
    const std::lock_guard lock(mutex_);
    received = end_.receive(datagram, from, to_wire(arrival));
    if (received.message && !sample_.ParseFromArray(received.message->data(),
                                                    static_cast<int>(received.message->size()))) {
      end_.message_unreadable();
      return wire::Rejection::kPayload;
    }
    if (received.message && plausible_reading(sample_.source_time_ns())) {
      end_.statistics().timed(wire::Duration(sample_.source_time_ns()), to_wire(arrival));
    }
  }
  tell(received.change);
  if (!received.message) return received.rejection;
  if (const auto sink = sink_.lock()) sink->on_udp_sample(sample_, arrival);
  return wire::Rejection::kNone;
}

void ServerPath::step(core::TimePoint now) {
  wire::PathChange change{};
  {
    const std::lock_guard lock(mutex_);
    change = end_.step(to_wire(now));
  }
  tell(change);
}

void ServerPath::rekey(const wire::PathKeys& keys) {
  {
    const std::lock_guard lock(mutex_);
    end_.rekey(keys);
  }
  if (const auto sink = sink_.lock()) sink->on_udp_keys(keys);
}

void ServerPath::tell(wire::PathChange change) {
  if (change == wire::PathChange::kNone) return;
  if (const auto sink = sink_.lock()) sink->on_udp_change(change);
}

}  // namespace haptic::server
