#pragma once
/// One session as gRPC sees it: proxy samples in, states, answers and events out (private to
/// server/rpc). The session is the stream: whatever ends it gives the lease up.

#include <grpcpp/support/server_callback.h>

#include <optional>
#include <string>
#include <utility>

#include "haptic/v1/session.pb.h"
#include "server/front/link_watch.hpp"
#include "server/front/pace.hpp"
#include "server/front/sample_ledger.hpp"
#include "server/rpc/peer.hpp"
#include "server/rpc/response_stream.hpp"
#include "server/udp/udp_path.hpp"

namespace haptic::server {

class SessionStream final
    : public ResponseStream<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>>,
      public UdpSink {
 public:
  /// Begins to read; deletes itself when gRPC is done with it.
  [[nodiscard]] static SessionStream* begin(ServiceContext& context, Peer peer);
  SessionStream(ServiceContext& context, Peer peer)
      : ResponseStream(context), peer_(std::move(peer)) {}

  bool offer(const core::TickRecord& record, StateFrame& frame, bool states_allowed) override;
  void goes_on_elsewhere(const std::string& session_id) override;
  void never_opened(const Refusal& why) override { end(to_status(why)); }
  void report(const std::string& device, v1::GetLinkStatsResponse& response) override;
  void OnReadDone(bool ok) override;
  void OnDone() override;

  // On the UDP port's thread.
  void on_udp_sample(const v1::ProxySample& sample, core::TimePoint arrival) override;
  void on_udp_change(wire::PathChange change) override;
  void on_udp_keys(const wire::PathKeys& keys) override;

 private:
  void read_next();
  void open(const v1::OpenSession& request);
  void open_as_controller(const v1::OpenSession& message);
  void open_as_tracker(const v1::OpenSession& message);
  void granted(const Lease& lease, const LeaseRequest& request);
  void opened(v1::Role role, const Lease& lease);
  void take_sample(const v1::ProxySample& sample, core::TimePoint arrival, Carrier carrier);
  void take_pose(const v1::TrackerSample& sample, core::TimePoint arrival);
  [[nodiscard]] std::optional<Refusal> refusal_of(const v1::OpenSession& request) const;
  void watch_link(const core::TickRecord& record, bool by_udp, bool by_stream) noexcept;
  void offer_udp(v1::SessionOpened& message);
  void tell_transport(const char* reason, const char* why);
  void flush() override;

  /// A client may change its carrier with every sample, as large ones and small ones come in turns:
  /// who listens is told so often, and no more.
  class TellLimit {
   public:
    static constexpr int kTold = 4;
    static constexpr core::Duration kIn{std::chrono::seconds(1)};
    [[nodiscard]] bool allows(core::TimePoint now) noexcept {
      if (now - since_ >= kIn) {
        since_ = now;
        told_ = 0;
      }
      return told_++ < kTold;
    }

   private:
    core::TimePoint since_{};
    int told_{0};
  };

  const Peer peer_;

  // Of the reading side, one callback at a time.
  grpc::ByteBuffer incoming_;
  v1::SessionRequest request_;
  bool first_message_{true};

  // Under the mutex.
  bool opened_{false};
  v1::SessionResponse greeting_;
  bool greeting_due_{false};
  std::string client_name_;
  v1::Role role_{v1::ROLE_UNSPECIFIED};
  std::uint32_t epoch_{0};  ///< 0: never held the lease
  std::uint32_t grant_{0};  ///< what the loop knows that lease by
  SampleLedger ledger_;
  LinkWatch link_;
  bool udp_wanted_{false};
  core::Duration nominal_period_{0};
  std::shared_ptr<UdpPath> udp_;
  std::optional<wire::PathKeys> new_keys_;  ///< to be sent
  Carrier samples_by_{Carrier::kGrpc}, samples_told_by_{Carrier::kGrpc};
  TellLimit tell_limit_;
  Carrier states_by_{Carrier::kNone};
  bool states_by_udp_{false};
  Pace pace_{1000.0, 0.0};
};

}  // namespace haptic::server
