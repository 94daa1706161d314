#include <cstdio>

#include "commands.hpp"

namespace haptic::ctl {

namespace {
/// A container's health check is asked every few seconds; an answer takes a millisecond.
constexpr std::chrono::milliseconds kPatience{2000};
}  // namespace

int health(const Options& options) {
  client::Connection server(options.server);
  const bool serving = server.healthy(options.device, kPatience);
  std::printf("%s\n", serving ? "serving" : "not serving");
  return serving ? 0 : 1;
}

}  // namespace haptic::ctl
