#pragma once
/// Calls the user's code, and remembers on which kind of thread it runs, because the library must
/// not wait for itself there: within a callback not for another callback, and on one of gRPC's few
/// threads not for a message, which needs such a thread to arrive.

#include <algorithm>
#include <cstdint>
#include <utility>

namespace haptic::client {

enum class CallbackThread : std::uint8_t { kNone, kOwn, kGrpc };

/// The callback that this thread runs, of any session or watch.
inline thread_local CallbackThread running_callback = CallbackThread::kNone;

/// Drops an exception that `callback` throws, as the public headers promise.
template <typename Callback, typename... Arguments>
void call_back(CallbackThread thread, const Callback& callback, const Arguments&... arguments) {
  const auto before = std::exchange(running_callback, std::max(running_callback, thread));
  try {
    callback(arguments...);
  } catch (...) {  // NOLINT(bugprone-empty-catch)
  }
  running_callback = before;
}

[[nodiscard]] inline bool in_callback() noexcept {
  return running_callback != CallbackThread::kNone;
}
[[nodiscard]] inline bool in_callback_of_grpc() noexcept {
  return running_callback == CallbackThread::kGrpc;
}

}  // namespace haptic::client
