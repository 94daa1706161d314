#pragma once
/// A line of the log: date, time and zone, level, message.
///
///   text  2026-03-01T09:30:00.125+01:00 info serving ...
///   json  {"time":"2026-03-01T09:30:00.125+01:00","level":"info","message":"serving ..."}
///
/// A message may hold text that came from a device or a client: control characters and invalid
/// UTF-8 are escaped, so that one message stays one line.

#include <spdlog/formatter.h>

#include <cstdint>
#include <memory>

namespace haptic::server {

enum class LogFormat : std::uint8_t { kText, kJson };

/// `for_journal`: each line begins with "<N>", its syslog priority, which journald takes off.
[[nodiscard]] std::unique_ptr<spdlog::formatter> log_formatter(LogFormat format, bool for_journal);

/// systemd connected standard error to the journal ($JOURNAL_STREAM names the same stream).
[[nodiscard]] bool stderr_is_journal();

}  // namespace haptic::server
