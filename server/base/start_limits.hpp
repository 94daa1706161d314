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
/// The same for stacks and memory, before anything else runs: a program ends by a signal without
/// them.
void check_memory_limits();

}  // namespace haptic::server
