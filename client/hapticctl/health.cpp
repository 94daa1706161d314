#include <cstdio>

#include "commands.hpp"

namespace haptic::ctl {

namespace {
/// A container's health check runs every few seconds; an answer takes a millisecond.
constexpr std::chrono::milliseconds kPatience{2000};
}  // namespace

int health(const Options& options) {
  const bool serving = connect(options).healthy(options.device, kPatience);
  if (options.json) {
    std::printf("{\"serving\":%s}\n", serving ? "true" : "false");
  } else {
    std::printf("%s\n", serving ? "serving" : "not serving");
  }
  return serving ? 0 : 1;
}

}  // namespace haptic::ctl
