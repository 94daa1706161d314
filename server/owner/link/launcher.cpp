#include "server/owner/link/launcher.hpp"

#include <fcntl.h>
#include <grp.h>
#include <linux/capability.h>
#include <poll.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <sys/sysinfo.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

constexpr int kLink = 3;  ///< descriptor of a front's link to the owner
constexpr int kCannotExec = 127;
constexpr core::Duration kAskEvery = std::chrono::milliseconds(500);

struct Order {
  enum class Kind : std::uint8_t { kStart, kKill, kAsk };
  Kind kind{Kind::kStart};
  pid_t pid{0};  ///< kKill
};

using Notice = Launcher::Notice;

/// Ids that own no file, for a front whose owner is root.
constexpr uid_t kNobody = 65534;
/// Addresses that a front may use for each byte of memory: malloc reserves far more than it uses.
/// Their page tables are counted nowhere else.
constexpr rlim_t kAddressesPerByte = 128;

void limit(__rlimit_resource resource, rlim_t most) {
  rlimit both{};
  getrlimit(resource, &both);
  both.rlim_cur = both.rlim_max = std::min(most, both.rlim_max);
  setrlimit(resource, &both);
}

/// Threads of a front, which has about 20. The kernel needs 20 KB and more for each, whatever its
/// stack is, and counts them with all of the user's: those of the host are no fewer.
constexpr rlim_t kThreads = 512;

/// Takes real-time rights and memory away. Only what the kernel always grants can fail here and in
/// take_rights_away(), so failures are not looked at: the front looks at its user again.
void take_means_away(const FrontLimits& limits) {
  const sched_param ordinary{};
  sched_setscheduler(0, SCHED_OTHER | SCHED_RESET_ON_FORK, &ordinary);
  cpu_set_t all;
  CPU_ZERO(&all);
  for (std::size_t cpu = 0; cpu < CPU_SETSIZE; ++cpu) CPU_SET(cpu, &all);
  sched_setaffinity(0, sizeof all, &all);
  if (limits.loop_cpu) {  // fails on a host of one core
    CPU_CLR(static_cast<std::size_t>(*limits.loop_cpu), &all);
    sched_setaffinity(0, sizeof all, &all);
  }
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + limits.nice);
  for (const auto resource : {RLIMIT_RTPRIO, RLIMIT_NICE, RLIMIT_MEMLOCK, RLIMIT_CORE,
                              RLIMIT_MSGQUEUE, RLIMIT_SIGPENDING}) {
    limit(resource, 0);
  }
  if (limits.memory_bytes != 0) {
    limit(RLIMIT_DATA, limits.memory_bytes);
    limit(RLIMIT_AS, kAddressesPerByte * limits.memory_bytes);
  }
  if (limits.stack_bytes != 0) limit(RLIMIT_STACK, limits.stack_bytes);
  limit(RLIMIT_NOFILE, 768);
  struct sysinfo host {};
  if (sysinfo(&host) == 0) limit(RLIMIT_NPROC, host.procs + kThreads);
  // If memory runs out on this host, the kernel ends the front and not the owner.
  const Descriptor first(open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC));
  static_cast<void>(::write(first.get(), "1000", 4) == 4);
}

/// Gives every right away. Root becomes user and group 65534, without other groups. One capability
/// stays until exec() takes it: it lets this user run a program that only root may read.
void take_rights_away() {
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  for (unsigned long capability = 0; capability <= CAP_LAST_CAP; ++capability) {
    prctl(PR_CAPBSET_DROP, capability, 0, 0, 0);
  }
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> had{}, kept{};
  if (geteuid() == 0) {
    syscall(SYS_capget, &header, had.data());
    kept[0].permitted = kept[0].effective = had[0].permitted & (1U << CAP_DAC_OVERRIDE);
    prctl(PR_SET_KEEPCAPS, 1, 0, 0, 0);
    setgroups(0, nullptr);
    static_cast<void>(setresgid(kNobody, kNobody, kNobody));
    static_cast<void>(setresuid(kNobody, kNobody, kNobody));
  }
  syscall(SYS_capset, &header, kept.data());
}

/// The front's side of fork().
[[noreturn]] void become_front(const char* program, int link, int log, const FrontLimits& limits,
                               pid_t launcher) {
  take_means_away(limits);
  take_rights_away();
  prctl(PR_SET_PDEATHSIG, SIGKILL);               // a change of user would have cancelled it
  if (getppid() != launcher) _exit(kCannotExec);  // it died before the line above
  for (const char* of_owner : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) {
    unsetenv(of_owner);
  }
  // First out of the way of the numbers that they get.
  link = fcntl(link, F_DUPFD_CLOEXEC, kLink + 1);
  log = fcntl(log, F_DUPFD_CLOEXEC, kLink + 1);
  const int null = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (null < 0 || dup2(null, STDIN_FILENO) < 0) close(STDIN_FILENO);  // a host without /dev
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  dup2(link, kLink);
  close_range(kLink + 1, ~0U, 0);
  execl(program, program, nullptr);
  _exit(kCannotExec);
}

/// The launcher's process, until the owner is gone.
class Service {
 public:
  Service(int socket, const char* program, const FrontLimits& limits)
      : socket_(socket), program_(program), limits_(limits) {}

  void run() {
    std::signal(SIGCHLD, SIG_DFL);  // who started hapticd may ignore it: no end would be told then
    sigset_t child;
    sigemptyset(&child);
    sigaddset(&child, SIGCHLD);
    sigset_t all;
    sigfillset(&all);
    sigprocmask(SIG_SETMASK, &all, nullptr);
    const int ended = signalfd(-1, &child, SFD_CLOEXEC | SFD_NONBLOCK);
    for (;;) {
      std::array<pollfd, 2> wait{{{socket_, POLLIN, 0}, {ended, POLLIN, 0}}};
      if (poll(wait.data(), wait.size(), -1) < 0 && errno != EINTR) return;
      signalfd_siginfo info{};
      while (read(ended, &info, sizeof info) > 0) continue;
      reap();
      if (!obey()) return;
    }
  }

 private:
  void reap() {
    int status = 0;
    for (pid_t pid = 0; (pid = waitpid(-1, &status, WNOHANG)) > 0;) {
      send(socket_, Notice{Notice::Kind::kEnded, pid, status});
    }
  }

  /// False: the owner is gone.
  bool obey() {
    for (;;) {
      Order order;
      std::vector<Descriptor> brought;
      switch (receive(socket_, order, &brought)) {
        case Received::kMessage:
          break;
        case Received::kNothing:
          return true;
        case Received::kOdd:
        case Received::kBurdened:
          continue;
        case Received::kGone:
          return false;
      }
      if (order.kind == Order::Kind::kKill) {
        // The number of a process that is no child any more may be another's by now.
        siginfo_t info{};
        const bool child =
            waitid(P_PID, static_cast<id_t>(order.pid), &info, WEXITED | WNOHANG | WNOWAIT) == 0;
        if (child && info.si_pid == 0) ::kill(order.pid, SIGKILL);
      } else if (order.kind == Order::Kind::kAsk) {
        send(socket_, Notice{Notice::Kind::kHere, 0, 0});
      } else if (brought.size() == 2) {
        start(brought[0].get(), brought[1].get());
      }
    }
  }

  void start(int link, int log) {
    const pid_t launcher = getpid();
    const pid_t pid = fork();
    if (pid == 0) {
      sigset_t none;
      sigemptyset(&none);
      sigprocmask(SIG_SETMASK, &none, nullptr);
      become_front(program_, link, log, limits_, launcher);
    }
    if (pid < 0) {
      send(socket_, Notice{Notice::Kind::kEnded, 0, errno});
    } else {
      send(socket_, Notice{Notice::Kind::kStarted, pid, 0});
    }
  }

  const int socket_;
  const char* const program_;
  const FrontLimits limits_;
};

}  // namespace

Launcher::Launcher(std::filesystem::path program, FrontLimits limits) {
  auto [ours, its] = packet_pair();
  pid_ = fork();
  if (pid_ < 0) throw core::TransportError(std::string("fork: ") + std::strerror(errno));
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    prctl(PR_SET_NAME, "hapticd-launch", 0, 0, 0);
    setsid();  // no front has hapticd's terminal as its own
    ours = Descriptor();
    Service(its.get(), program.c_str(), limits).run();
    _exit(0);
  }
  socket_ = std::move(ours);
}

Launcher::~Launcher() {
  socket_ = Descriptor();
  if (pid_ > 0) {
    ::kill(pid_, SIGKILL);  // its fronts die with it
    waitpid(pid_, nullptr, 0);
  }
}

std::string Notice::words() const {
  if (pid == 0) return std::string("cannot be started: ") + std::strerror(status);
  if (WIFSIGNALED(status)) return std::string("was ended by SIG") + sigabbrev_np(WTERMSIG(status));
  return "ended with status " + std::to_string(WEXITSTATUS(status));
}

void Launcher::start(Descriptor link, Descriptor log) {
  const std::array<int, 2> both{link.get(), log.get()};
  if (!send(socket_.get(), Order{Order::Kind::kStart, 0}, both)) {
    throw core::TransportError("the launcher of the front is gone");
  }
}

void Launcher::kill(pid_t front) {
  if (front > 0) send(socket_.get(), Order{Order::Kind::kKill, front});
}

std::optional<Launcher::Notice> Launcher::next() {
  Notice notice;
  const Received got = receive(socket_.get(), notice);
  gone_ = gone_ || got == Received::kGone;
  answered_ = answered_ || got == Received::kMessage;
  return got == Received::kMessage ? std::optional(notice) : std::nullopt;
}

bool Launcher::is_silent(core::TimePoint now) {
  if (answered_ && now - asked_ >= kAskEvery) {
    asked_ = now;
    answered_ = !send(socket_.get(), Order{Order::Kind::kAsk, 0});
  }
  return !answered_ && now - asked_ >= kPatience;
}

}  // namespace haptic::server
