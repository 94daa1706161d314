#pragma once
/// Which thread the user's code runs on. In a callback it must not wait for another callback; on a
/// thread of gRPC's also not for what only such a thread can bring, for there are few of them.

#include <algorithm>

namespace haptic::client {

/// Exists while this thread runs a callback of the user's, of any session or watch.
class CallbackScope {
 public:
  enum class Thread { kNone, kOwn, kGrpc };

  explicit CallbackScope(bool on_grpc_thread) noexcept : before_(running()) {
    running() = std::max(before_, on_grpc_thread ? Thread::kGrpc : Thread::kOwn);
  }
  ~CallbackScope() { running() = before_; }
  CallbackScope(const CallbackScope&) = delete;
  CallbackScope& operator=(const CallbackScope&) = delete;

  /// Which kind of callback this thread is in.
  [[nodiscard]] static Thread& running() noexcept {
    thread_local Thread thread = Thread::kNone;
    return thread;
  }

 private:
  const Thread before_;
};

[[nodiscard]] inline bool in_callback() noexcept {
  return CallbackScope::running() != CallbackScope::Thread::kNone;
}
[[nodiscard]] inline bool in_callback_of_grpc() noexcept {
  return CallbackScope::running() == CallbackScope::Thread::kGrpc;
}

}  // namespace haptic::client
