#include "server/front/udp/session_path.hpp"

#include <string>
#include <utility>

#include "server/front/session/link_report.hpp"
#include "server/front/session/messages.hpp"

namespace haptic::server {
namespace {

void to_proto(const wire::PathKeys& keys, const UdpPort& port, v1::UdpPath& message) {
  const auto bytes = [](const auto& array) { return std::string(array.begin(), array.end()); };
  message.set_host(port.host());
  message.set_port(port.port());
  message.set_path_id(keys.path_id);
  message.set_up_key(bytes(keys.up.key));
  message.set_up_salt(bytes(keys.up.salt));
  message.set_down_key(bytes(keys.down.key));
  message.set_down_salt(bytes(keys.down.salt));
}

}  // namespace

std::shared_ptr<SessionPath> SessionPath::open(UdpPort& port, std::shared_ptr<Session> session,
                                               v1::UdpPath& offer) {
  const core::Duration period = session->nominal_period();
  auto carrier = std::make_shared<SessionPath>(port, std::move(session));
  UdpPort::Opened opened = port.open(std::weak_ptr<UdpSink>(carrier), period);
  carrier->path_ = std::move(opened.path);
  to_proto(opened.keys, port, offer);
  return carrier;
}

std::optional<v1::UdpPath> SessionPath::take_keys() {
  std::optional<wire::PathKeys> keys;
  {
    const std::lock_guard lock(mutex_);
    keys = std::exchange(new_keys_, std::nullopt);
  }
  if (!keys) return std::nullopt;
  v1::UdpPath message;
  to_proto(*keys, port_, message);
  return message;
}

void SessionPath::report(v1::LinkTransport& udp) const {
  udp.set_transport(v1::TRANSPORT_UDP);
  report_samples(session_->figures(Carrier::kUdp), *udp.mutable_up());
  path_->with([&](const wire::PathEnd& end) {
    const wire::LinkCounters& counters = end.counters();
    v1::LinkDirection& up = *udp.mutable_up();
    up.set_received(counters.received);
    up.set_bytes(counters.bytes);
    up.set_lost(counters.lost);
    up.set_reordered(counters.reordered);
    up.set_duplicate(counters.duplicate());
    up.set_late(counters.late());
    for (std::size_t i = 1; i < counters.rejected.size(); ++i) {
      add_rejected(wire::name(static_cast<wire::Rejection>(i)), counters.rejected[i],
                   *up.mutable_rejected());
    }
    if (counters.longest_gap > wire::Duration(0)) {
      set(*up.mutable_longest_gap(), counters.longest_gap);
    }
    const wire::PeerReport& report = end.peer_report();
    udp.mutable_down()->set_received(report.received);
    udp.mutable_down()->set_lost(report.newest - report.received);
    set_round_trip(end.round_trip(), udp);
  });
}

void SessionPath::on_udp_sample(const v1::ProxySample& sample, core::TimePoint arrival) {
  session_->take(sample, arrival, Carrier::kUdp, clock(arrival));
}

void SessionPath::on_udp_change(wire::PathChange change) {
  const bool by_udp = path_->with([](const wire::PathEnd& end) { return end.in_use(); });
  if (by_udp == std::exchange(states_by_udp_, by_udp)) return;
  session_->tell_transport(by_udp ? "STATES GRPC -> UDP" : "STATES UDP -> GRPC",
                           wire::name(change));
}

void SessionPath::on_udp_keys(const wire::PathKeys& keys) {
  const std::lock_guard lock(mutex_);
  new_keys_ = keys;
}

void report_unassigned(const UdpPort& port, v1::GetLinkStatsResponse& response) {
  for (std::size_t i = 1; i < wire::kRejections; ++i) {
    const auto why = static_cast<wire::Rejection>(i);
    add_rejected(wire::name(why), port.rejected(why), *response.mutable_unassigned());
  }
}

}  // namespace haptic::server
