#pragma once
/// Where the user's code runs: in a callback it must not wait for another, and on a thread of gRPC's
/// not for what only such a thread can bring.

namespace haptic::client {

/// This thread runs a callback of the user's, of whatever session or watch.
[[nodiscard]] bool in_callback() noexcept;
/// And it is one of gRPC's: of its few threads this one brings nothing until the callback returned.
[[nodiscard]] bool in_callback_of_grpc() noexcept;

/// Around a callback.
class CallbackScope {
 public:
  explicit CallbackScope(bool on_grpc_thread) noexcept;
  ~CallbackScope();
  CallbackScope(const CallbackScope&) = delete;
  CallbackScope& operator=(const CallbackScope&) = delete;

 private:
  const int before_;
};

}  // namespace haptic::client
