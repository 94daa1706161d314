#pragma once
/// Limits that the host must grant before hapticd starts at all. Libraries abort without a word if
/// they get no descriptor or no thread, so both are asked for first.

#include <cstddef>
#include <string>

namespace haptic::server {

/// "may start 3 threads (ulimit -u): WHY; needs at least `wanted`"; empty: it may start so many.
[[nodiscard]] std::string lack_of_threads(std::size_t wanted);

/// Throws std::runtime_error that names the limit, its value and what is needed.
void check_start_limits();

}  // namespace haptic::server
