#pragma once
/// The daemon's log on standard error. A thread that logs never waits for the reader of the log: a
/// stopped terminal or a full pipe must not delay an emergency stop or a SIGTERM.
///
/// A line: date, time and zone, level, message.
///
///   text  2026-03-01T09:30:00.125+01:00 info serving ...
///   json  {"time":"2026-03-01T09:30:00.125+01:00","level":"info","message":"serving ..."}
///
/// A message may hold text that came from a device or a client: control characters, marks of
/// writing direction and (in JSON) invalid UTF-8 are escaped, so that one message stays one line.

#include <spdlog/formatter.h>

#include <cstdint>
#include <memory>

namespace haptic::server {

/// kBare: the priority and the message, for the owner, which logs what its front says.
enum class LogFormat : std::uint8_t { kText, kJson, kBare };

/// `for_journal`, and kBare: each line begins with "<N>", its syslog priority, which journald takes
/// off.
[[nodiscard]] std::unique_ptr<spdlog::formatter> log_formatter(LogFormat format, bool for_journal);

/// systemd connected standard error to the journal ($JOURNAL_STREAM names the same stream).
[[nodiscard]] bool stderr_is_journal();

/// Makes standard error spdlog's default logger. Lines go through a queue to a thread of their own;
/// if the queue is full, the oldest lines are dropped.
void log_to_stderr(LogFormat format);
/// SCHED_FIFO at the lowest priority for the log's thread. It holds the queue's lock while it takes
/// a line out, and a real-time thread that logs must not wait for the ordinary programs that would
/// interrupt it then.
void log_in_realtime();
/// Waits a moment for the last lines to be read, and logs how many were dropped. After it the
/// process may end even if the log's thread is still blocked in a write.
void finish_log();

}  // namespace haptic::server
