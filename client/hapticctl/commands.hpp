#pragma once
/// The commands of hapticctl; each returns its exit code and throws ClientError.

#include <cstdint>
#include <string>
#include <vector>

namespace haptic::ctl {

struct Options {
  std::string server{"127.0.0.1:50051"};
  std::string device{};
  bool json{false};
  double rate_hz{10.0};
  double seconds{0.0};
  bool hold{false};
  std::string reason{};
  std::vector<std::uint32_t> faults{};
};

int info(const Options& options);
int watch(const Options& options);
int engage(const Options& options);
int estop(const Options& options);
int clear_fault(const Options& options);

/// Fault numbers as names, "DEVICE_SILENT, LOOP_LATE"; "none".
[[nodiscard]] std::string fault_names(std::uint32_t faults);
/// False once SIGINT or SIGTERM came, or `seconds` (0: never) have passed since the first call.
[[nodiscard]] bool go_on(double seconds);

}  // namespace haptic::ctl
