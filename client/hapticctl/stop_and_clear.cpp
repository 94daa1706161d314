#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"

namespace haptic::ctl {

using nlohmann::json;

int estop(const Options& options) {
  const auto stopped = connect(options).emergency_stop(options.device, options.reason);
  if (options.json) {
    std::printf("%s\n", json{{"stopped", stopped}}.dump().c_str());
    return 0;
  }
  for (const std::string& device : stopped) std::printf("stopped: %s\n", device.c_str());
  return 0;
}

int clear_fault(const Options& options) {
  std::uint32_t bits = 0;
  for (const std::uint32_t fault : connect(options).clear_fault(options.device, options.faults)) {
    bits |= 1U << (fault & 31U);
  }
  const std::vector<std::string> cleared = client::fault_names(bits);
  if (options.json) {
    std::printf("%s\n", json{{"cleared", cleared}}.dump().c_str());
  } else {
    std::printf("cleared: %s\n", joined(cleared).c_str());
  }
  return 0;
}

}  // namespace haptic::ctl
