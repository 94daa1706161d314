#include "server/front/confinement.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/futex.h>
#include <linux/seccomp.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace {

using haptic::server::confine;
using haptic::server::confine_by_landlock;
using haptic::server::confine_sockets;
using haptic::server::UsesTls;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr uid_t kNobody = 65534;

struct Call {
  const char* what{nullptr};
  long number{0};
  std::array<unsigned long, 5> arguments{};
};

/// Both steps of the front: `shared` is there before the first, `sockets` come after it.
void confine_all(std::span<const int> shared = {}, std::span<const int> sockets = {}) {
  static_cast<void>(confine(UsesTls::kNo, shared));
  confine_sockets(sockets);
}

/// Empty: each fails with `error`; else those that do not.
std::string others_than(int error, const std::vector<Call>& calls) {
  std::string found;
  for (const Call& call : calls) {
    const auto& with = call.arguments;
    errno = 0;
    const long got = syscall(call.number, with[0], with[1], with[2], with[3], with[4]);
    if (got == -1 && errno == error) continue;
    found += std::string(call.what) + (got == -1 ? ": " + std::to_string(errno) : " WORKS") + "\n";
    if (call.number == SYS_fork && got == 0) _exit(0);
  }
  return found;
}

/// The words of `attack` in a process of its own; "status N" if it ended without a word.
std::string in_child(const std::function<std::string()>& attack) {
  std::array<int, 2> ends{};
  EXPECT_EQ(pipe(ends.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    const std::string words = attack() + "\n";
    _exit(write(ends[1], words.data(), words.size()) < 0 ? 1 : 0);
  }
  close(ends[1]);
  std::string words;
  std::array<char, 4096> bytes{};
  for (ssize_t got = 0; (got = read(ends[0], bytes.data(), bytes.size())) > 0;) {
    words.append(bytes.data(), static_cast<std::size_t>(got));
  }
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (words.empty()) return "status " + std::to_string(status);
  words.pop_back();
  return words;
}

void take_landlock_away() {
  void* const filter = seccomp_init(SCMP_ACT_ALLOW);
  seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SYS_landlock_create_ruleset, 0);
  seccomp_load(filter);
}

const std::vector<Call> kProcesses{{"kill", SYS_kill, {static_cast<unsigned long>(-1), 0}},
                                   {"kill itself", SYS_kill, {0, 0}},
                                   {"tkill", SYS_tkill, {1, 0}},
                                   {"tgkill of another", SYS_tgkill, {1, 1, 0}},
                                   {"rt_sigqueueinfo", SYS_rt_sigqueueinfo, {1}},
                                   {"rt_tgsigqueueinfo", SYS_rt_tgsigqueueinfo, {1, 1}},
                                   {"pidfd_open", SYS_pidfd_open, {1}},
                                   {"pidfd_send_signal", SYS_pidfd_send_signal, {9}},
                                   {"pidfd_getfd", SYS_pidfd_getfd, {9}},
                                   {"process_vm_readv", SYS_process_vm_readv, {1}},
                                   {"process_vm_writev", SYS_process_vm_writev, {1}},
                                   {"process_madvise", SYS_process_madvise, {9}},
                                   {"process_mrelease", 448, {9}},
                                   {"ptrace", SYS_ptrace, {16, 1}},
                                   {"kcmp", SYS_kcmp, {1, 1}},
                                   {"fork", SYS_fork},
                                   {"clone of a process", SYS_clone, {SIGCHLD}},
                                   {"clone of a network", SYS_clone, {CLONE_THREAD | CLONE_NEWNET}},
                                   {"execve", SYS_execve},
                                   {"execveat", SYS_execveat},
                                   {"unshare", SYS_unshare, {CLONE_NEWUSER}},
                                   {"setns", SYS_setns, {9}},
                                   {"setsid", SYS_setsid},
                                   {"setpgid", SYS_setpgid},
                                   {"prlimit64 of another", SYS_prlimit64, {1, 0}},
                                   {"get_robust_list", SYS_get_robust_list, {1}},
                                   {"a lock that boosts another", SYS_futex, {0, FUTEX_LOCK_PI}},
                                   {"many waits in one", 449},
                                   {"another's pidfd", SYS_getsockopt, {9, SOL_SOCKET, 77}}};

const std::vector<Call> kFiles{{"openat", SYS_openat, {9}},
                               {"openat2", SYS_openat2, {9}},
                               {"open_by_handle_at", SYS_open_by_handle_at, {9}},
                               {"readlinkat", SYS_readlinkat, {9}},
                               {"memfd_create", SYS_memfd_create},
                               {"unlinkat", SYS_unlinkat, {9}},
                               {"mkdirat", SYS_mkdirat, {9}},
                               {"mknodat", SYS_mknodat, {9}},
                               {"fchmod", SYS_fchmod, {9}},
                               {"fchmodat", SYS_fchmodat, {9}},
                               {"fsetxattr", SYS_fsetxattr, {9}},
                               {"renameat2", SYS_renameat2, {9}},
                               {"fallocate", SYS_fallocate, {9}},
                               {"ftruncate", SYS_ftruncate, {9}},
                               {"flock", SYS_flock, {9}},
                               {"dup", SYS_dup, {9}},
                               {"dup3", SYS_dup3, {9, 10}},
                               {"an owner of signals", SYS_fcntl, {9, F_SETOWN}},
                               {"an owner of signals, long", SYS_fcntl, {9, F_SETOWN_EX}},
                               {"its signal", SYS_fcntl, {9, F_SETSIG, SIGKILL}},
                               {"signals", SYS_fcntl, {9, F_SETFL, O_ASYNC}},
                               {"a lease", SYS_fcntl, {9, F_SETLEASE}},
                               {"notices of a folder", SYS_fcntl, {9, F_NOTIFY}},
                               {"seals", SYS_fcntl, {9, F_ADD_SEALS}},
                               {"a lock", SYS_fcntl, {9, F_SETLK}},
                               {"a pipe's size", SYS_fcntl, {9, F_SETPIPE_SZ}},
                               {"inotify_init1", SYS_inotify_init1},
                               {"fanotify_init", SYS_fanotify_init},
                               {"splice", SYS_splice, {9}},
                               {"mount", SYS_mount},
                               {"chroot", SYS_chroot},
                               {"to type into a terminal", SYS_ioctl, {9, TIOCSTI}},
                               {"to type into a console", SYS_ioctl, {9, TIOCLINUX}},
                               {"a terminal's settings", SYS_ioctl, {9, TCGETS}},
                               {"a terminal's discipline", SYS_ioctl, {9, TIOCSETD}},
                               {"a terminal of its own", SYS_ioctl, {9, TIOCSCTTY}},
                               {"signals of a file", SYS_ioctl, {9, FIOASYNC}}};

const std::vector<Call> kSockets{
    {"connect", SYS_connect, {9}},
    {"socket", SYS_socket, {AF_UNIX, SOCK_STREAM}},
    {"a socket of the kernel", SYS_socket, {AF_NETLINK, SOCK_RAW}},
    {"socketpair", SYS_socketpair, {AF_UNIX, SOCK_STREAM}},
    {"bind", SYS_bind, {9}},
    {"listen", SYS_listen, {9}},
    {"a filter", SYS_setsockopt, {9, SOL_SOCKET, SO_ATTACH_FILTER}},
    {"a program as filter", SYS_setsockopt, {9, SOL_SOCKET, SO_ATTACH_BPF}},
    {"a filter for good", SYS_setsockopt, {9, SOL_SOCKET, SO_LOCK_FILTER}},
    {"a choice of listener", SYS_setsockopt, {9, SOL_SOCKET, SO_ATTACH_REUSEPORT_CBPF}},
    {"a close that waits", SYS_setsockopt, {9, SOL_SOCKET, SO_LINGER}},
    {"a datagram that is not finished", SYS_sendto, {9, 0, 0, MSG_MORE}},
    {"to connect by data", SYS_sendto, {9, 0, 0, MSG_FASTOPEN}},
    {"to connect by a message", SYS_sendmsg, {9, 0, MSG_FASTOPEN | MSG_NOSIGNAL}}};

const std::vector<Call> kMeans{
    {"membarrier", SYS_membarrier},
    {"sched_setaffinity", SYS_sched_setaffinity},
    {"sched_setscheduler", SYS_sched_setscheduler},
    {"sched_setattr", SYS_sched_setattr},
    {"setpriority", SYS_setpriority},
    {"ioprio_set", SYS_ioprio_set},
    {"holes in memory", SYS_madvise, {0, 0, MADV_REMOVE}},
    {"shared memory", SYS_mmap, {0, 4096, PROT_READ, MAP_SHARED | MAP_ANONYMOUS}},
    {"a program in memory", SYS_mmap, {0, 4096, PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS}},
    {"memory counted as a stack",
     SYS_mmap,
     {0, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_GROWSDOWN}},
    {"the host's huge pages",
     SYS_mmap,
     {0, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_HUGETLB}},
    {"memory made a program", SYS_mprotect, {0, 0, PROT_EXEC}},
    {"shmget", SYS_shmget},
    {"shmat", SYS_shmat},
    {"msgget", SYS_msgget},
    {"semget", SYS_semget},
    {"mq_open", SYS_mq_open},
    {"mlockall", SYS_mlockall},
    {"mbind", SYS_mbind},
    {"move_pages", SYS_move_pages},
    {"userfaultfd", SYS_userfaultfd},
    {"io_uring_setup", SYS_io_uring_setup},
    {"io_setup", SYS_io_setup},
    {"bpf", SYS_bpf},
    {"perf_event_open", SYS_perf_event_open},
    {"keyctl", SYS_keyctl},
    {"setresuid", SYS_setresuid},
    {"capset", SYS_capset},
    {"personality", SYS_personality},
    {"to be traced", SYS_prctl, {PR_SET_DUMPABLE, 1}},
    {"to outlive its owner", SYS_prctl, {PR_SET_PDEATHSIG, 0}},
    {"seccomp", SYS_seccomp, {SECCOMP_SET_MODE_FILTER}},
    {"landlock_create_ruleset", SYS_landlock_create_ruleset},
    {"timer_create", SYS_timer_create},
    {"timerfd_create", SYS_timerfd_create},
    {"signalfd4", SYS_signalfd4, {9}},
    {"syslog", SYS_syslog},
    {"clock_settime", SYS_clock_settime}};

/// Whoever the front runs as, and whatever Landlock knows.
TEST(Confinement, RefusesWhatServingDoesNotNeed) {
  for (const bool landlock : {true, false}) {
    for (const uid_t user : {getuid(), kNobody}) {
      const std::string words = in_child([&]() -> std::string {
        if (!landlock) take_landlock_away();
        if (getuid() != user && setresuid(user, user, user) != 0) return "no user";
        confine_all();
        std::string found;
        for (const auto* calls : {&kProcesses, &kFiles, &kSockets, &kMeans}) {
          found += others_than(EPERM, *calls);
        }
        return found;
      });
      EXPECT_THAT(words, IsEmpty()) << "user " << user << (landlock ? "" : ", no Landlock");
    }
  }
}

TEST(Confinement, LandlockHoldsByItself) {
  EXPECT_EQ(in_child([]() -> std::string {
              prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
              const std::string missing = confine_by_landlock();
              if (missing.find("no Landlock") != std::string::npos) return "";
              const pid_t parent = getppid();
              std::string got = open("/etc/passwd", O_RDONLY) >= 0 ? "reads a file\n" : "";
              if (missing.empty() && kill(parent, 0) == 0) got += "signals\n";
              return got;
            }),
            "");
}

TEST(Confinement, SaysWhatTheKernelLacks) {
  EXPECT_THAT(in_child([] {
                take_landlock_away();
                return confine_by_landlock();
              }),
              HasSubstr("no Landlock: seccomp alone"));
}

TEST(Confinement, HoldsInEarlierThreads) {
  EXPECT_EQ(in_child([]() -> std::string {
              std::atomic<bool> confined{false};
              std::string words;
              std::thread early([&] {
                while (!confined) std::this_thread::yield();
                words = others_than(EPERM, kSockets);
              });
              confine_all();
              confined = true;
              early.join();
              return words;
            }),
            "");
}

TEST(Confinement, KeepsWhatTheOwnerShares) {
  for (const bool later : {false, true}) {
    const auto words = in_child([later] {
      const std::array shared{socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0)};
      const std::span<const int> none;
      confine_all(later ? none : shared, later ? shared : none);
      const auto one = static_cast<unsigned long>(shared[0]);
      const unsigned long odd = one | 1UL << 32U;  // the kernel takes it for the same
      return others_than(EPERM, {{"flags", SYS_fcntl, {one, F_SETFL, 0}},
                                 {"flags, odd", SYS_fcntl, {odd, F_SETFL, 0}},
                                 {"a copy", SYS_fcntl, {one, F_DUPFD_CLOEXEC, 0}},
                                 {"to block", SYS_ioctl, {one, FIONBIO}},
                                 {"to block, odd", SYS_ioctl, {odd, FIONBIO}},
                                 {"to watch it", SYS_epoll_ctl, {99, EPOLL_CTL_ADD, one}},
                                 {"shutdown", SYS_shutdown, {one, SHUT_RDWR}},
                                 {"shutdown, odd", SYS_shutdown, {odd, SHUT_RDWR}},
                                 {"buffers", SYS_setsockopt, {one, SOL_SOCKET, SO_RCVBUF}}});
    });
    EXPECT_THAT(words, IsEmpty()) << (later ? "what came later" : "what was there");
  }
}

TEST(Confinement, ServingStillWorks) {
  EXPECT_EQ(
      in_child([] {
        confine_all();
        std::string words =
            others_than(EBADF, {{"accept4", SYS_accept4, {99}},
                                {"sendmsg", SYS_sendmsg, {99}},
                                {"flags", SYS_fcntl, {99, F_SETFL}},
                                {"a copy", SYS_fcntl, {99, F_DUPFD_CLOEXEC}},
                                {"no delay", SYS_setsockopt, {99, IPPROTO_TCP, TCP_NODELAY}},
                                {"its state", SYS_getsockopt, {99, IPPROTO_TCP, TCP_INFO}}});
        std::thread([&] { words += others_than(EFAULT, {{"time", SYS_clock_gettime}}); }).join();
        return words;
      }),
      "");
  EXPECT_EQ(in_child([]() -> std::string {
              confine_all();
              std::abort();
            }),
            "status " + std::to_string(SIGABRT));
}

#ifdef __x86_64__
TEST(Confinement, AnotherAbiEndsTheProcess) {
  const auto end = [](auto call) {
    return in_child([&]() -> std::string {
      confine_all();
      call();
      return "goes on";
    });
  };
  const std::string by_seccomp = "status " + std::to_string(SIGSYS);
  EXPECT_EQ(end([] {
              long number = 20;  // getpid of i386
              asm volatile("int $0x80" : "+a"(number) : : "memory");
            }),
            by_seccomp);
  EXPECT_EQ(end([] { syscall(0x40000000 | SYS_getpid); }), by_seccomp);  // x32
}
#endif

}  // namespace
