#pragma once
/// How calls end: a refusal as a grpc::Status, and unary calls that the owner answers later
/// (private to server/rpc).

#include <grpcpp/alarm.h>
#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>

#include "server/front/refusals.hpp"

namespace haptic::server {

/// Canonical code, message, ErrorInfo {reason, domain "hapticd"}, and a BadRequest if a field is
/// off.
[[nodiscard]] grpc::Status to_status(const Refusal& refusal);

/// Finishes `reactor` exactly once: by an answer, or with UNAVAILABLE if no tick came at all. The
/// owner's own bound (PendingRequests::kPatience) is the shorter one while the loop runs.
class TickReply : public std::enable_shared_from_this<TickReply> {
 public:
  static constexpr std::chrono::milliseconds kPatience{500};

  explicit TickReply(grpc::ServerUnaryReactor* reactor) : reactor_(reactor) {}

  /// `give_up` is called if no answer came in time, before the call is finished.
  void watch(std::function<void()> give_up);
  /// The first call finishes; `fill` writes the response just before, and only then.
  void finish(const grpc::Status& status, const std::function<void()>& fill = {});

 private:
  grpc::ServerUnaryReactor* reactor_;
  std::atomic<bool> finished_{false};
  std::mutex mutex_;
  std::unique_ptr<grpc::Alarm> alarm_;
};

}  // namespace haptic::server
