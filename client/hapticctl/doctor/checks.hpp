#pragma once
/// The single questions of examine().

#include "doctor/examine.hpp"

namespace haptic::ctl {

[[nodiscard]] Finding check_kernel(const HostFiles& host);
[[nodiscard]] Finding check_realtime(const HostAnswers& answers);
[[nodiscard]] Finding check_memory(const HostAnswers& answers);
[[nodiscard]] Finding check_idle(const HostAnswers& answers);
/// CPU time that the control group (v2) leaves to this process.
[[nodiscard]] Finding check_cgroup(const HostFiles& host);
[[nodiscard]] Finding check_governor(const HostFiles& host);
[[nodiscard]] Finding check_jitter(const Jitter& jitter, double period_s);
/// The USB serial ports of the host, as "/dev/ttyACM0".
[[nodiscard]] std::vector<std::string> serial_ports(const HostFiles& host);
/// One finding per USB serial port; without a port one finding that says so.
[[nodiscard]] std::vector<Finding> check_serial(const HostFiles& host, const HostAnswers& answers);
/// The longest time that a serial adapter of this host holds received bytes back, s; 0 if no
/// adapter has a latency timer.
[[nodiscard]] double serial_latency(const HostFiles& host);

}  // namespace haptic::ctl
