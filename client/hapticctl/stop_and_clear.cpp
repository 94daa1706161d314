#include <cstdio>

#include "commands.hpp"

namespace haptic::ctl {

int estop(const Options& options) {
  client::Connection server = connect(options);
  for (const std::string& device : server.emergency_stop(options.device, options.reason)) {
    std::printf("stopped: %s\n", device.c_str());
  }
  return 0;
}

int clear_fault(const Options& options) {
  client::Connection server = connect(options);
  std::uint32_t bits = 0;
  for (const std::uint32_t fault : server.clear_fault(options.device, options.faults)) {
    bits |= 1U << (fault & 31U);
  }
  std::printf("cleared: %s\n", joined(client::fault_names(bits)).c_str());
  return 0;
}

}  // namespace haptic::ctl
