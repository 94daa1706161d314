#pragma once
/// One watch: states of a device to anyone, conflated to a rate (private to server/rpc).

#include <grpcpp/support/server_callback.h>

#include <memory>
#include <mutex>
#include <string>

#include "haptic/v1/haptic_service.pb.h"
#include "server/rpc/pace.hpp"
#include "server/rpc/service_context.hpp"

namespace haptic::server {

class WatchStream final : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                          public Subscriber,
                          public OpenStream,
                          public std::enable_shared_from_this<WatchStream> {
 public:
  static constexpr double kDefaultRateHz = 30.0;

  /// Deletes itself when gRPC is done with it.
  [[nodiscard]] static WatchStream* begin(ServiceContext& context, const grpc::ByteBuffer& request);
  explicit WatchStream(ServiceContext& context) : OpenStream(context.streams), context_(context) {}

  bool offer(const core::TickRecord& record, StateFrame& frame, bool states_allowed) override;
  void server_closes() override;

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  void open(const grpc::ByteBuffer& request);
  void end(const grpc::Status& status);
  void flush();
  void write(grpc::ByteBuffer buffer);

  ServiceContext& context_;
  std::shared_ptr<WatchStream> self_;

  std::mutex mutex_;
  bool ended_{false};
  bool writing_{false};
  grpc::Status final_status_;
  grpc::ByteBuffer outgoing_;
  ServiceContext::Target target_{};
  std::string id_;
  std::shared_ptr<EventQueue> events_;
  Pace pace_{1000.0, kDefaultRateHz};
};

}  // namespace haptic::server
