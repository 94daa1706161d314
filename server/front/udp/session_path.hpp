#pragma once
/// The datagram path of a session, next to its stream: carries states while it is in use, and
/// brings samples.

#include <memory>
#include <mutex>
#include <optional>

#include "haptic/v1/haptic_service.pb.h"
#include "server/front/net/wire_time.hpp"
#include "server/front/session/session.hpp"
#include "server/front/udp/udp_port.hpp"

namespace haptic::server {

class SessionPath final : public UdpSink {
 public:
  /// Opens a path for `session`, and says in `offer` where it is and its keys. `port` must outlive
  /// this.
  [[nodiscard]] static std::shared_ptr<SessionPath> open(UdpPort& port,
                                                         std::shared_ptr<Session> session,
                                                         v1::UdpPath& offer);
  SessionPath(UdpPort& port, std::shared_ptr<Session> session)
      : port_(port), session_(std::move(session)) {}

  /// A serialised DeviceState; never blocks. False: the path is not in use.
  [[nodiscard]] bool send_state(wire::ConstBytes state) { return path_->send_state(state); }
  /// New keys for the client, to go by the stream; absent: there are none.
  [[nodiscard]] std::optional<v1::UdpPath> take_keys();
  /// The client's steady clock against the server's, by the path's challenges.
  [[nodiscard]] Session::ClockEstimate clock(core::TimePoint now) const {
    return path_->with(
        [now](const wire::PathEnd& end) { return end.clock_offset().at(to_wire(now)); });
  }
  /// Datagrams, challenges among them, and the samples that the ingress refused.
  void report(v1::LinkTransport& udp) const;
  /// Tells the client, and forgets the path.
  void close() { port_.close(path_); }

  // On the port's thread.
  void on_udp_sample(const v1::ProxySample& sample, core::TimePoint arrival) override;
  void on_udp_change(wire::PathChange change) override;
  void on_udp_keys(const wire::PathKeys& keys) override;

 private:
  UdpPort& port_;
  const std::shared_ptr<Session> session_;
  std::shared_ptr<ServerPath> path_{};
  bool states_by_udp_{false};  ///< the port's thread only
  std::mutex mutex_;
  std::optional<wire::PathKeys> new_keys_{};
};

/// The port's datagrams that no session answers for.
void report_unassigned(const UdpPort& port, v1::GetLinkStatsResponse& response);

}  // namespace haptic::server
