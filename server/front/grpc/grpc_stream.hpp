#pragma once
/// A stream of the service that gRPC carries (private to server/front/grpc): it lives until gRPC is
/// done with it.

#include <grpcpp/support/byte_buffer.h>

#include <memory>
#include <utility>

#include "server/front/grpc/reply.hpp"
#include "server/front/service/response_stream.hpp"

namespace haptic::server {

/// `Reactor`: gRPC's, writing ByteBuffers. `Stream`: a ResponseStream.
template <typename Reactor, typename Stream>
class GrpcStream : public Reactor, public Stream {
 public:
  using Stream::Stream;

  void OnCancel() override { this->lost(); }
  void OnWriteDone(bool ok) override { this->written(ok); }
  void OnDone() override { const auto last = std::move(self_); }

 protected:
  void keep_alive() { self_ = this->shared_from_this(); }
  void write(Outgoing message) override {
    this->writing_ = true;
    outgoing_ = to_buffer(std::move(message));
    this->StartWrite(&outgoing_);
  }

 private:
  void finish(const std::optional<Refusal>& why) override { this->Finish(to_status(why)); }

  std::shared_ptr<ResponseStream> self_;
  grpc::ByteBuffer outgoing_;
};

}  // namespace haptic::server
