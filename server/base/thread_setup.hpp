#pragma once
/// The first call of every thread of the server.

namespace haptic::server {

/// For the calling thread: blocks every signal (main alone waits for them) and gives it a name of
/// at most 15 characters, as `top -H` shows it.
void set_thread_up(const char* name) noexcept;

}  // namespace haptic::server
