#include "server/owner/link/launcher.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/sysinfo.h>
#include <sys/wait.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <string>

#include "tests/support/temporary_file.hpp"

namespace {

using haptic::server::Descriptor;
using haptic::server::Launcher;
using haptic::server::packet_pair;
using Notice = Launcher::Notice;

Descriptor null() {
  return Descriptor(open("/dev/null", O_RDWR | O_CLOEXEC));
}

std::optional<Notice> wait_for(Launcher& launcher) {
  pollfd wait{launcher.descriptor(), POLLIN, 0};
  poll(&wait, 1, 60'000);
  return launcher.next();
}

/// A program of one line of shell.
class Script {
 public:
  explicit Script(const std::string& line) : file_("#!/bin/sh\n" + line + "\n", "front") {
    // A front of root is nobody, and its shell reads the file as that.
    std::filesystem::permissions(file_.path(), std::filesystem::perms(0755));
    std::filesystem::permissions(file_.path().parent_path(), std::filesystem::perms(0755));
  }
  [[nodiscard]] std::filesystem::path path() const { return file_.path(); }

 private:
  haptic::test::TemporaryFile file_;
};

/// Message of a shell script that runs as a front, on its link.
std::string told_by(const std::string& script, std::optional<int> loop_cpu = {}) {
  const Script program("exec >&3; " + script);
  Launcher launcher(program.path(), {64U << 20U, 0, 5, loop_cpu});
  auto [here, there] = packet_pair();
  launcher.start(std::move(there), null());
  while (const auto notice = wait_for(launcher)) {
    if (notice->kind == Notice::Kind::kEnded) break;
  }
  std::string text;
  std::array<char, 4096> bytes{};
  for (ssize_t got = 0; (got = read(here.get(), bytes.data(), bytes.size())) > 0;) {
    text.append(bytes.data(), static_cast<std::size_t>(got));
  }
  return text;
}

TEST(Launcher, TellsHowAFrontEnded) {
  const Script program("exit 7");
  Launcher launcher(program.path(), {});
  auto [here, there] = packet_pair();
  launcher.start(std::move(there), null());
  const auto started = wait_for(launcher);
  ASSERT_TRUE(started);
  EXPECT_EQ(started->kind, Notice::Kind::kStarted);
  const auto ended = wait_for(launcher);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->kind, Notice::Kind::kEnded);
  EXPECT_EQ(ended->pid, started->pid);
  EXPECT_EQ(WEXITSTATUS(ended->status), 7);
}

TEST(Launcher, TellsEndsThoughSigchldIsIgnored) {
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  const Script program("exit 7");
  Launcher launcher(program.path(), {});
  std::signal(SIGCHLD, before);
  auto [here, there] = packet_pair();
  launcher.start(std::move(there), null());
  ASSERT_TRUE(wait_for(launcher));
  const auto ended = wait_for(launcher);
  ASSERT_TRUE(ended);
  EXPECT_EQ(WEXITSTATUS(ended->status), 7);
}

TEST(Launcher, ARefusedForkIsNoSignal) {
  EXPECT_EQ((Notice{Notice::Kind::kEnded, 0, EAGAIN}.words()),
            "cannot be started: Resource temporarily unavailable");
  EXPECT_EQ((Notice{Notice::Kind::kEnded, 7, SIGSEGV}.words()), "was ended by SIGSEGV");
}

TEST(Launcher, EndsAFrontThatHangs) {
  const Script program("exec sleep 1000");
  Launcher launcher(program.path(), {});
  auto [here, there] = packet_pair();
  launcher.start(std::move(there), null());
  const auto started = wait_for(launcher);
  ASSERT_TRUE(started);
  ASSERT_EQ(kill(started->pid, SIGSTOP), 0);
  launcher.kill(started->pid);
  const auto ended = wait_for(launcher);
  ASSERT_TRUE(ended);
  EXPECT_EQ(WTERMSIG(ended->status), SIGKILL);
}

TEST(Launcher, FrontsEndWithIt) {
  pid_t front = 0;
  {
    const Script program("exec sleep 1000");
    Launcher launcher(program.path(), {});
    auto [here, there] = packet_pair();
    launcher.start(std::move(there), null());
    const auto started = wait_for(launcher);
    ASSERT_TRUE(started);
    front = started->pid;
  }
  for (int i = 0; i < 1000 && kill(front, 0) == 0; ++i) usleep(10'000);
  EXPECT_NE(kill(front, 0), 0);
}

TEST(Launcher, ThreadsOfAFrontAreBounded) {
  struct sysinfo host {};
  ASSERT_EQ(sysinfo(&host), 0);
  const int most = std::atoi(told_by("awk '/Max processes/ {print $3}' /proc/self/limits").c_str());
  EXPECT_GT(most, 500);
  EXPECT_LT(most, host.procs + 1500) << "those of the host, and some hundreds";
}

TEST(Launcher, OnlyFrontsAreKilled) {
  const Script program("exec sleep 1000");
  Launcher launcher(program.path(), {});
  launcher.kill(getpid());  // no child of the launcher
  auto [here, there] = packet_pair();
  launcher.start(std::move(there), null());
  EXPECT_TRUE(wait_for(launcher));
}

TEST(Launcher, AFrontHasNoRights) {
  const std::string said =
      told_by("grep -E '^(Cap(Inh|Prm|Eff|Bnd|Amb)|NoNewPrivs)' /proc/self/status");
  EXPECT_EQ(said,
            "CapInh:\t0000000000000000\nCapPrm:\t0000000000000000\nCapEff:\t0000000000000000\n"
            "CapBnd:\t0000000000000000\nCapAmb:\t0000000000000000\nNoNewPrivs:\t1\n");
}

TEST(Launcher, AFrontOfRootIsNobody) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root";
  EXPECT_EQ(told_by("id -u; id -G"), "65534\n65534\n");
}

TEST(Launcher, AFrontHasLittleMemory) {
  // Resource, soft and hard limit; the largest addresses are 128 for each byte.
  EXPECT_EQ(told_by("sed -nE 's/^(Max (data|address|locked|msgqueue|core|pending).*[a-z]) {2,}"
                    "([0-9]+) +([0-9]+).*/\\2 \\3 \\4/p' /proc/self/limits"),
            "data 67108864 67108864\ncore 0 0\nlocked 0 0\naddress 8589934592 8589934592\n"
            "pending 0 0\nmsgqueue 0 0\n");
  EXPECT_EQ(told_by("cat /proc/self/oom_score_adj"), "1000\n");
}

TEST(Launcher, AFrontHasNoTerminal) {
  EXPECT_EQ(told_by("test $(ps -o sid= -p $$) != " + std::to_string(getsid(0)) + " && echo apart"),
            "apart\n");
  EXPECT_EQ(told_by("(: </dev/tty) 2>/dev/null || echo none"), "none\n");
}

/// Built by root where no other user may look.
TEST(Launcher, FindsAFrontOnlyRootReads) {
  const haptic::test::ScratchFolder folder;
  const auto program = folder.path() / "front";
  std::filesystem::copy("/bin/true", program);
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  Launcher launcher(program, {});
  auto [here, there] = packet_pair();
  launcher.start(std::move(there), null());
  ASSERT_TRUE(wait_for(launcher));
  const auto ended = wait_for(launcher);
  ASSERT_TRUE(ended);
  EXPECT_EQ(WEXITSTATUS(ended->status), 0);
}

TEST(Launcher, FrontsKeepOffTheLoopsCore) {
  const std::string all = told_by("nproc"), others = told_by("nproc", 0);
  const int cores = std::stoi(all);
  EXPECT_EQ(std::stoi(others), cores == 1 ? 1 : cores - 1);
  if (cores > 1) {
    EXPECT_EQ(told_by("grep -c 'Cpus_allowed_list:.*\\b0\\b' /proc/self/status", 0), "0\n");
  }
}

TEST(Launcher, FrontsHoldNoStreamOfOthers) {
  const Script program("cat; echo out; echo err >&2");
  Launcher launcher(program.path(), {});
  auto [here, there] = packet_pair();
  auto [log, its_log] = packet_pair();
  launcher.start(std::move(there), std::move(its_log));
  while (const auto notice = wait_for(launcher)) {
    if (notice->kind == Notice::Kind::kEnded) break;
  }
  std::array<char, 4> word{};
  for (const char* said : {"out\n", "err\n"}) {
    ASSERT_EQ(haptic::server::receive(log.get(), word), haptic::server::Received::kMessage);
    EXPECT_EQ(std::string(word.data(), word.size()), said);
  }
}

TEST(Launcher, ThatIsStoppedIsSilent) {
  constexpr auto kLater = 2 * Launcher::kPatience;
  Launcher launcher("/bin/true", {});
  haptic::core::TimePoint now(std::chrono::hours(1));
  EXPECT_FALSE(launcher.is_silent(now));
  ASSERT_TRUE(wait_for(launcher));
  EXPECT_FALSE(launcher.is_silent(now += kLater)) << "it answered";
  ASSERT_TRUE(wait_for(launcher));
  ASSERT_EQ(kill(launcher.pid(), SIGSTOP), 0);
  EXPECT_FALSE(launcher.is_silent(now += kLater)) << "it is asked";
  EXPECT_TRUE(launcher.is_silent(now += kLater));
  ASSERT_EQ(kill(launcher.pid(), SIGCONT), 0);
  ASSERT_TRUE(wait_for(launcher));
  EXPECT_FALSE(launcher.is_silent(now));
}

TEST(Launcher, AFrontInheritsItsLinkAlone) {
  const Descriptor other(dup(2));  // dup() does not close on exec: the launcher has it, a front not
  EXPECT_EQ(told_by("exec ls /proc/self/fd"), "0\n1\n2\n3\n4\n");  // 4: the folder that ls reads
}

}  // namespace
