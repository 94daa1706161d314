#pragma once
/// A session's stream on gRPC: reads requests, writes what the Session has for the client, and
/// offers the datagram path (private to server/rpc). The stream's end is the session's.

#include <grpcpp/support/server_callback.h>

#include <memory>
#include <string>
#include <utility>

#include "haptic/v1/session.pb.h"
#include "server/front/session.hpp"
#include "server/rpc/peer.hpp"
#include "server/rpc/response_stream.hpp"
#include "server/udp/session_path.hpp"

namespace haptic::server {

class SessionStream final
    : public ResponseStream<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>> {
 public:
  /// Begins to read; deletes itself when gRPC is done with it.
  [[nodiscard]] static SessionStream* begin(ServiceContext& context, Peer peer);
  SessionStream(ServiceContext& context, Peer peer)
      : ResponseStream(context, peer.account), peer_(std::move(peer)) {}

  bool offer(const StateRecord& state, StateFrame& frame, bool states_allowed) override;
  void goes_on_elsewhere(const std::string& session_id) override;
  void lease_over() override;
  void end_with(const Refusal& why) override { end(to_status(why)); }
  void report(const std::string& device, v1::GetLinkStatsResponse& response) override;
  void OnReadDone(bool ok) override;
  void OnDone() override;

 private:
  void read_next();
  void take(const v1::SessionRequest& request, core::TimePoint arrival);
  void open(const v1::OpenSession& request);
  void opened(v1::SessionOpened greeting, const v1::OpenSession& request);
  void offer_udp(v1::SessionOpened& message);
  void flush() override;
  void close(Ending ending) override;
  [[nodiscard]] std::shared_ptr<Session> session();

  const Peer peer_;

  // The reading side, one callback at a time.
  grpc::ByteBuffer incoming_;
  v1::SessionRequest request_;
  bool first_message_{true};

  // Under the mutex.
  std::shared_ptr<Session> session_{};  ///< null before OpenSession
  std::shared_ptr<SessionPath> udp_{};  ///< null: it has no datagram path
  bool opened_{false};
  v1::SessionResponse greeting_;
  bool greeting_due_{false};
};

}  // namespace haptic::server
