#pragma once
/// Limits that the host must grant before hapticd starts at all. Libraries abort without a word if
/// they get no descriptor or no thread, so both are asked for first.

namespace haptic::server {

/// Throws std::runtime_error that names the limit, its value and what is needed.
void check_start_limits();

}  // namespace haptic::server
