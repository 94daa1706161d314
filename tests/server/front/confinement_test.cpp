#include "server/front/confinement.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <thread>

namespace {

using haptic::server::confine;

/// Runs `attack` in a confined process of its own; true: it answered true there.
bool confined(const std::function<bool()>& attack) {
  const pid_t child = fork();
  if (child == 0) {
    static_cast<void>(confine());
    _exit(attack() ? 7 : 8);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 7;
}

/// Each thing that is refused: tests/hostile/front/calls.cpp.
TEST(Confinement, ThreadsInheritIt) {
  const pid_t owner = getpid();
  EXPECT_TRUE(confined([=] {
    bool held = false;
    std::thread([&] { held = kill(owner, SIGCONT) == -1; }).join();
    return held;
  }));
}

TEST(Confinement, ServingStillWorks) {
  EXPECT_TRUE(confined([] { return open("/etc/hosts", O_RDONLY) >= 0; }));
  EXPECT_TRUE(confined([] { return socket(AF_INET, SOCK_STREAM, 0) >= 0; }));
  EXPECT_TRUE(confined([] { return raise(SIGCONT) == 0; }));
}

}  // namespace
