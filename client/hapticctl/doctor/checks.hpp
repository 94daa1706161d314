#pragma once
/// The single questions of examine().

#include <cstdio>

#include "doctor/examine.hpp"

namespace haptic::ctl {

/// By printf's rules; up to 159 characters.
template <typename... Values>
[[nodiscard]] std::string format(const char* pattern, Values... values) {
  char text[160];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

[[nodiscard]] Finding check_kernel(const HostFiles& host);
[[nodiscard]] Finding check_realtime(const HostFiles& host, const HostAnswers& answers);
[[nodiscard]] Finding check_memory(const HostAnswers& answers);
/// CPU time that the control group leaves to this process.
[[nodiscard]] Finding check_cgroup(const HostFiles& host);
/// Kernels with RT_GROUP_SCHED (cgroup v1) give every group a real-time budget of its own, which is
/// 0 until it is set.
[[nodiscard]] bool without_realtime_budget(const HostFiles& host);
[[nodiscard]] Finding check_governor(const HostFiles& host);
[[nodiscard]] Finding check_jitter(const Jitter& jitter, double period_s);
/// One finding per USB serial port; without a port one finding that says so.
[[nodiscard]] std::vector<Finding> check_serial(const HostFiles& host, const HostAnswers& answers);
/// The longest time that a serial adapter of this host holds received bytes back, s; 0 if no
/// adapter has a latency timer.
[[nodiscard]] double serial_latency(const HostFiles& host);

}  // namespace haptic::ctl
