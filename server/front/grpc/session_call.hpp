#pragma once
/// A session's stream on gRPC (private to server/front/grpc).

#include <grpcpp/support/server_callback.h>

#include "server/front/grpc/grpc_stream.hpp"
#include "server/front/service/session_stream.hpp"

namespace haptic::server {

class SessionCall final
    : public GrpcStream<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                        SessionStream> {
 public:
  /// Begins to read; deletes itself when gRPC is done with it.
  [[nodiscard]] static SessionCall* begin(ServiceContext& context, Peer peer);
  using GrpcStream::GrpcStream;

  void OnReadDone(bool ok) override;
  void OnDone() override;

 private:
  void start_read() override { StartRead(&incoming_); }

  // One callback at a time.
  grpc::ByteBuffer incoming_;
  v1::SessionRequest request_;
};

}  // namespace haptic::server
