#pragma once
/// The daemon's log on standard error. A thread that logs never waits for the reader of the log: a
/// stopped terminal or a full pipe must not delay an emergency stop or a SIGTERM.

#include "server/telemetry/log_format.hpp"

namespace haptic::server {

/// Makes standard error spdlog's default logger. Lines go through a queue to a thread of their own;
/// if the queue is full, the oldest lines are dropped.
void log_to_stderr(LogFormat format);
/// Waits a moment for the last lines to be read, and logs how many were dropped. After it the
/// process may end even if the log's thread is still blocked in a write.
void finish_log();

}  // namespace haptic::server
