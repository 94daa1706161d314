#pragma once
/// Calls the user's code, and remembers on which kind of thread it runs. In a callback the library
/// must not wait for another callback; on a thread of gRPC, which has few, it must not wait for
/// what only such a thread can bring.

#include <algorithm>
#include <cstdint>
#include <utility>

namespace haptic::client {

enum class CallbackThread : std::uint8_t { kNone, kOwn, kGrpc };

/// The callback that this thread runs, of any session or watch.
inline thread_local CallbackThread running_callback = CallbackThread::kNone;

/// What `callback` throws ends here: the contract is that no exception crosses a callback.
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
