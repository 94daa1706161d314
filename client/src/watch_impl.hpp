#pragma once
/// A telemetry stream: the callbacks run on gRPC's thread of this stream, one at a time; the next
/// message is read when a callback returned, so that a slow one conflates at the server.

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <functional>
#include <mutex>

#include "haptic/client/watch.hpp"
#include "haptic/v1/haptic_service.grpc.pb.h"

namespace haptic::client {

class Watch::Impl final : public grpc::ClientReadReactor<v1::WatchResponse> {
 public:
  Impl(std::shared_ptr<grpc::Channel> channel, const std::string& device, double rate_hz,
       std::function<void(const DeviceState&)> on_state,
       std::function<void(const Event&)> on_event);
  ~Impl() override;

  [[nodiscard]] bool running() const;
  [[nodiscard]] std::optional<ClientError> error() const;
  [[nodiscard]] std::uint64_t conflated() const;

 private:
  void OnReadDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::HapticService::Stub> stub_;
  std::function<void(const DeviceState&)> on_state_;
  std::function<void(const Event&)> on_event_;
  grpc::ClientContext context_;
  v1::WatchRequest request_;
  v1::WatchResponse response_;
  mutable std::mutex mutex_;
  std::condition_variable ended_;
  bool running_{true};
  std::optional<ClientError> error_{};
  std::uint64_t conflated_{0};
};

}  // namespace haptic::client
