#pragma once
/// The single questions of examine().

#include "doctor/examine.hpp"

namespace haptic::ctl {

[[nodiscard]] Finding check_kernel(const HostFiles& host);
[[nodiscard]] Finding check_realtime(const HostFiles& host, const HostAnswers& answers);
[[nodiscard]] Finding check_memory(const HostAnswers& answers);
[[nodiscard]] Finding check_cgroup(const HostFiles& host);
[[nodiscard]] Finding check_governor(const HostFiles& host);
[[nodiscard]] Finding check_jitter(const Jitter& jitter, double period_s);
/// One per serial port; where there is none, one that says so.
[[nodiscard]] std::vector<Finding> check_serial(const HostFiles& host, const HostAnswers& answers);
/// The longest that a serial adapter of this host sits on what it received, s; 0 where none says.
[[nodiscard]] double serial_latency(const HostFiles& host);

}  // namespace haptic::ctl
