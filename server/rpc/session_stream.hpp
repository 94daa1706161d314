#pragma once
/// One session as gRPC sees it: proxy samples in, states, answers and events out (private to
/// server/rpc). The session is the stream: whatever ends it gives the lease up.

#include <grpcpp/support/server_callback.h>

#include <memory>
#include <mutex>
#include <string>

#include "haptic/v1/session.pb.h"
#include "server/rpc/pace.hpp"
#include "server/rpc/sample_ledger.hpp"
#include "server/rpc/service_context.hpp"

namespace haptic::server {

class SessionStream final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                            public Subscriber,
                            public OpenStream,
                            public std::enable_shared_from_this<SessionStream> {
 public:
  /// Begins to read; deletes itself when gRPC is done with it.
  [[nodiscard]] static SessionStream* begin(ServiceContext& context);
  explicit SessionStream(ServiceContext& context)
      : OpenStream(context.streams), context_(context) {}

  bool offer(const core::TickRecord& record, StateFrame& frame, bool states_allowed) override;
  void server_closes() override;

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  void read_next();
  void open(const v1::OpenSession& request);
  void open_as_controller(const v1::OpenSession& request);
  void granted(const Lease& lease);
  void opened(v1::Role role, const Lease& lease);
  void take_sample(const v1::ProxySample& sample, core::TimePoint arrival);
  void end(const grpc::Status& status);
  void give_up_what_is_held();
  /// Under the mutex: starts the next write that is not a state, if none is under way.
  void flush();
  void write(grpc::ByteBuffer buffer);

  ServiceContext& context_;
  std::shared_ptr<SessionStream> self_;

  // Of the reading side, one callback at a time.
  grpc::ByteBuffer incoming_;
  v1::SessionRequest request_;
  bool first_message_{true};

  std::mutex mutex_;
  bool ended_{false};
  bool writing_{false};
  bool opened_{false};
  grpc::Status final_status_;
  grpc::ByteBuffer outgoing_;
  v1::SessionResponse greeting_;
  bool greeting_due_{false};
  ServiceContext::Target target_{};
  std::string id_;
  std::string client_name_;
  std::uint32_t epoch_{0};  ///< 0: never held the lease
  std::shared_ptr<EventQueue> events_;
  SampleLedger ledger_;
  Pace pace_{1000.0, 0.0};
};

}  // namespace haptic::server
