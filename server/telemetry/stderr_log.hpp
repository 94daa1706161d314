#pragma once
/// The daemon's log on standard error. Nobody who logs waits for whoever reads it: a terminal that was
/// stopped or a full pipe must not stand between an emergency stop, or a SIGTERM, and the device.

namespace haptic::server {

/// Makes it spdlog's default logger: lines go through a queue to a thread of their own; where the
/// queue is full the oldest give way.
void log_to_stderr();
/// Gives the last lines a moment to be read, and says how many gave way. Then the process may end,
/// whether or not the thread of the log is stuck.
void finish_log();

}  // namespace haptic::server
