#include "server/front/confinement.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
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

bool refused(long result) {
  return result == -1;
}

TEST(Confinement, NoOtherProcessCanBeHurt) {
  const pid_t owner = getpid();
  EXPECT_TRUE(confined([=] { return refused(kill(owner, SIGCONT)); }));
  EXPECT_TRUE(confined([=] { return refused(kill(-1, 0)); }));
  EXPECT_TRUE(confined([=] { return refused(ptrace(PTRACE_ATTACH, owner, nullptr, nullptr)); }));
  const std::string memory = "/proc/" + std::to_string(owner) + "/mem";
  EXPECT_TRUE(confined([=] { return refused(open(memory.c_str(), O_RDONLY)); }));
}

TEST(Confinement, DevicesAndFilesAreClosed) {
  const char* const file = "/dev/ptmx";
  ASSERT_GE(open(file, O_RDWR | O_CLOEXEC), 0);
  EXPECT_TRUE(confined([=] { return refused(open(file, O_RDWR)); }));
  EXPECT_TRUE(confined([] { return refused(open("/tmp/x", O_CREAT | O_RDWR, 0600)); }));
  EXPECT_TRUE(confined([] { return open("/etc/hosts", O_RDONLY) >= 0; }));
}

TEST(Confinement, NoProgramAndNoRealTime) {
  EXPECT_TRUE(confined([] { return refused(execl("/bin/true", "true", nullptr)); }));
  EXPECT_TRUE(confined([] { return refused(fork()); }));
  const sched_param highest{99};
  EXPECT_TRUE(confined([=] { return refused(sched_setscheduler(0, SCHED_FIFO, &highest)); }));
}

TEST(Confinement, ThreadsInheritIt) {
  const pid_t owner = getpid();
  EXPECT_TRUE(confined([=] {
    bool held = false;
    std::thread([&] { held = refused(kill(owner, SIGCONT)); }).join();
    return held;
  }));
}

TEST(Confinement, ServingStillWorks) {
  EXPECT_TRUE(confined([] { return socket(AF_INET, SOCK_STREAM, 0) >= 0; }));
  EXPECT_TRUE(confined([] { return raise(SIGCONT) == 0; }));
}

}  // namespace
