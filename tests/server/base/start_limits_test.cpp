#include "server/base/start_limits.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <iostream>

namespace haptic::server {
namespace {

/// In a process of its own: says what is missing under `limit`, or "enough".
[[noreturn]] void say_under(int resource, rlim_t limit) {
  const rlimit few{limit, limit};
  if (resource == RLIMIT_NPROC && getuid() == 0 && setuid(60'124) != 0) _exit(2);
  setrlimit(static_cast<__rlimit_resource>(resource), &few);
  try {
    resource == RLIMIT_STACK ? check_memory_limits() : check_start_limits();
    std::cerr << "enough\n";
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
  }
  _exit(0);
}

#ifndef __SANITIZE_ADDRESS__  // the undefined behaviour sanitizer checks a type with a pipe
TEST(StartLimits, NamesTheLackOfDescriptors) {
  EXPECT_EXIT(say_under(RLIMIT_NOFILE, 5), testing::ExitedWithCode(0),
              "may open 5 files at a time .* needs at least 64");
  EXPECT_EXIT(say_under(RLIMIT_NOFILE, 64), testing::ExitedWithCode(0), "enough");
}
#endif

TEST(StartLimits, NamesTheLackOfMemory) {
  EXPECT_EXIT(say_under(RLIMIT_STACK, 64 << 10), testing::ExitedWithCode(0),
              "may use 64 KB of stack .ulimit -s.: needs at least 512 KB");
  EXPECT_EXIT(say_under(RLIMIT_STACK, 1 << 20), testing::ExitedWithCode(0), "enough");
}

TEST(StartLimits, NamesTheLackOfThreads) {
  EXPECT_EXIT(say_under(RLIMIT_NPROC, 1), testing::ExitedWithCode(0),
              "may start 0 threads .*: Resource temporarily unavailable; needs at least 24");
}

}  // namespace
}  // namespace haptic::server
