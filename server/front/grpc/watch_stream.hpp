#pragma once
/// One watch: states of a device to anyone, conflated to a rate (private to server/front/grpc).

#include <grpcpp/support/server_callback.h>

#include "haptic/v1/haptic_service.pb.h"
#include "server/front/grpc/grpc_stream.hpp"
#include "server/front/session/pace.hpp"

namespace haptic::server {

class WatchStream final
    : public GrpcStream<grpc::ServerWriteReactor<grpc::ByteBuffer>, ResponseStream> {
 public:
  static constexpr double kDefaultRateHz = 30.0;

  /// Deletes itself when gRPC is done with it.
  [[nodiscard]] static WatchStream* begin(ServiceContext& context, const grpc::ByteBuffer& request,
                                          std::shared_ptr<Account> account);
  using GrpcStream::GrpcStream;

  bool offer(const SerialisedState& state, StateFrame& frame, bool states_allowed) override;

 private:
  void open(const grpc::ByteBuffer& raw);
  void flush() override;
  void close(Ending ending) override;

  // Under the mutex.
  SessionId id_{};  ///< empty: not admitted
  std::shared_ptr<EventQueue> events_{};
  Pace pace_{1000.0, kDefaultRateHz};
};

}  // namespace haptic::server
