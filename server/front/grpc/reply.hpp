#pragma once
/// How calls end: a refusal as a grpc::Status, and unary calls that the owner answers later
/// (private to server/front/grpc).

#include <grpcpp/alarm.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <functional>
#include <memory>
#include <mutex>

#include "server/front/service/calls.hpp"
#include "server/front/service/state_frame.hpp"

namespace haptic::server {

/// See rich_status().
[[nodiscard]] grpc::Status to_status(const Refusal& refusal);

/// `message` without a copy of what streams share.
[[nodiscard]] grpc::ByteBuffer to_buffer(Outgoing message);

/// Ends a unary call of gRPC.
class GrpcReply : public Reply {
 public:
  explicit GrpcReply(grpc::ServerUnaryReactor* reactor) : reactor_(reactor) {}

  void watch(std::function<void()> give_up) override;

 protected:
  void send(const std::optional<Refusal>& why) override;

 private:
  grpc::ServerUnaryReactor* reactor_;
  std::mutex mutex_;
  std::unique_ptr<grpc::Alarm> alarm_;
};

}  // namespace haptic::server
