#pragma once
/// The daemon's log on standard error, which never waits for whoever reads it: a terminal that was
/// stopped or a full pipe must not stand between an emergency stop, or a SIGTERM, and the device.

namespace haptic::server {

/// Makes it spdlog's default logger, and gRPC's. A line that cannot be written at once is lost, and
/// the next one that can is preceded by how many were.
void log_to_stderr();

}  // namespace haptic::server
