#include "server/front/confinement.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <linux/landlock.h>
#include <linux/sockios.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/ssl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <memory>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/base/descriptor.hpp"
#include "server/base/process.hpp"

namespace haptic::server {
namespace {

// Not in Debian 12's <linux/landlock.h>, which knows version 2.
constexpr std::uint64_t kTruncate = 1ULL << 14;
constexpr std::uint64_t kIoctlDevice = 1ULL << 15;
constexpr std::uint64_t kBindAndConnect = 3;
constexpr std::uint64_t kNamesAndSignals = 3;
struct Ruleset {
  std::uint64_t handled_access_fs{0};
  std::uint64_t handled_access_net{0};
  std::uint64_t scoped{0};
};

[[noreturn]] void fail(const std::string& what) {
  throw core::TransportError("confinement of the front: " + what + ": " + std::strerror(errno));
}

/// Linux 6.2 and later do not, unless they are told to.
bool types_into_terminals() {
  const Descriptor file(open("/proc/sys/dev/tty/legacy_tiocsti", O_RDONLY | O_CLOEXEC));
  char value = '1';
  return !file || read(file.get(), &value, 1) != 1 || value != '0';
}

/// One seccomp filter. The strictest answer of all loaded ones counts.
class Filter {
 public:
  explicit Filter(std::uint32_t otherwise) : filter_(seccomp_init(otherwise), &seccomp_release) {
    if (!filter_) fail("seccomp_init");
  }

  /// `call` gets `answer` if all conditions, on different arguments, hold. A comparison sees 64
  /// bits of an argument, and the kernel 32 of an int: so a denial compares by a mask.
  void add(std::uint32_t answer, const char* call, const std::vector<scmp_arg_cmp>& conditions) {
    const int number = seccomp_syscall_resolve_name(call);
    if (number == __NR_SCMP_ERROR) {
      throw core::TransportError(std::string("confinement of the front: no system call ") + call);
    }
    if (number < 0) return;  // not on this machine
    check(seccomp_rule_add_array(filter_.get(), answer, number,
                                 static_cast<unsigned>(conditions.size()), conditions.data()),
          call);
  }

  void load(bool log) {
    set(SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS);
    set(SCMP_FLTATR_CTL_TSYNC, 1);
    set(SCMP_FLTATR_CTL_OPTIMIZE, 2);  // a tree, not a list
    set(SCMP_FLTATR_CTL_LOG, log ? 1 : 0);
    check(seccomp_load(filter_.get()), "seccomp_load");
  }

 private:
  void set(scmp_filter_attr attribute, std::uint32_t value) {
    check(seccomp_attr_set(filter_.get(), attribute, value), "seccomp_attr_set");
  }
  static void check(int result, const char* what) {
    if (result == 0) return;
    errno = -result;
    fail(what);
  }

  const std::unique_ptr<void, decltype(&seccomp_release)> filter_;
};

constexpr std::uint32_t kRefused = SCMP_ACT_ERRNO(EPERM);
constexpr scmp_datum_t kInt = 0xFFFFFFFF;

constexpr scmp_arg_cmp is(unsigned argument, scmp_datum_t value) {
  return {argument, SCMP_CMP_EQ, value, 0};
}
constexpr scmp_arg_cmp masked(unsigned argument, scmp_datum_t mask, scmp_datum_t value) {
  return {argument, SCMP_CMP_MASKED_EQ, mask, value};
}

/// Calls that are allowed with any argument: on what is open, on its own memory, threads and time.
/// refuse_quietly() refuses some of them.
const char* const kServing[] = {"accept4",
                                "brk",
                                "clock_getres",
                                "clock_gettime",
                                "clock_nanosleep",
                                "clone3",
                                "close",
                                "epoll_create1",
                                "epoll_ctl",
                                "epoll_pwait",
                                "epoll_pwait2",
                                "epoll_wait",
                                "eventfd2",
                                "exit",
                                "exit_group",
                                "fstat",
                                "getpeername",
                                "getpid",
                                "getrandom",
                                "getrusage",
                                "getsockname",
                                "gettid",
                                "gettimeofday",
                                "lseek",
                                "mremap",
                                "munmap",
                                "nanosleep",
                                "newfstatat",
                                "openat",
                                "poll",
                                "ppoll",
                                "pread64",
                                "read",
                                "readv",
                                "recvfrom",
                                "recvmsg",
                                "restart_syscall",
                                "rseq",
                                "rt_sigaction",
                                "rt_sigprocmask",
                                "rt_sigreturn",
                                "sched_getaffinity",
                                "sched_getparam",
                                "sched_getscheduler",
                                "sched_yield",
                                "sendmsg",
                                "sendto",
                                "set_robust_list",
                                "shutdown",
                                "sigaltstack",
                                "socket",
                                "sysinfo",
                                "timerfd_create",
                                "timerfd_settime",
                                "uname",
                                "write",
                                "writev"};

void allow_by_argument(Filter& filter) {
  const auto allow = [&](const char* call, auto... conditions) {
    filter.add(SCMP_ACT_ALLOW, call, {conditions...});
  };
  // Threads yes, processes and namespaces no. abort() signals the own process.
  constexpr scmp_datum_t kNamespaces = CLONE_NEWNS | CLONE_NEWCGROUP | CLONE_NEWUTS | CLONE_NEWIPC |
                                       CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNET;
  allow("clone", masked(0, CLONE_THREAD | CLONE_PTRACE | kNamespaces, CLONE_THREAD));
  allow("tgkill", is(0, static_cast<scmp_datum_t>(getpid())));
  // A lock with priority inheritance may name another process's thread as its owner.
  for (const int wait_or_wake : {FUTEX_WAIT, FUTEX_WAKE, FUTEX_WAIT_BITSET, FUTEX_WAKE_BITSET}) {
    allow("futex", masked(1, kInt & FUTEX_CMD_MASK, static_cast<scmp_datum_t>(wait_or_wake)));
  }
  // Memory of its own, counted by RLIMIT_DATA. No advice makes holes into what is shared.
  allow("mmap", masked(2, PROT_EXEC, 0), masked(3, MAP_TYPE, MAP_PRIVATE));
  allow("mprotect", masked(2, PROT_EXEC, 0));
  for (const int advice :
       {MADV_DONTNEED, MADV_FREE, MADV_HUGEPAGE, MADV_NOHUGEPAGE, MADV_DONTDUMP}) {
    allow("madvise", is(2, static_cast<scmp_datum_t>(advice)));
  }
  for (const unsigned command : {F_GETFL, F_GETFD, F_SETFD, F_DUPFD_CLOEXEC}) {
    allow("fcntl", is(1, command));
  }
  allow("fcntl", is(1, F_SETFL), masked(2, O_ASYNC, 0));
  for (const unsigned request : {FIONBIO, SIOCINQ, SIOCOUTQ, TCGETS})
    allow("ioctl", is(1, request));
  allow("prctl", is(0, PR_SET_NAME));
  allow("prlimit64", is(0, 0));
  for (const auto& [level, option] : {std::pair{SOL_SOCKET, SO_RCVBUF},
                                      {SOL_SOCKET, SO_TIMESTAMPNS},
                                      {IPPROTO_TCP, TCP_NODELAY},
                                      {IPPROTO_TCP, TCP_USER_TIMEOUT},
                                      {IPPROTO_TCP, TCP_INQ}}) {
    allow("setsockopt", is(1, static_cast<scmp_datum_t>(level)),
          is(2, static_cast<scmp_datum_t>(option)));
  }
  for (const auto& [level, option] :
       {std::pair{SOL_SOCKET, SO_ERROR}, {SOL_SOCKET, SO_PEERCRED}, {IPPROTO_TCP, TCP_INFO}}) {
    allow("getsockopt", is(1, static_cast<scmp_datum_t>(level)),
          is(2, static_cast<scmp_datum_t>(option)));
  }
}

/// Refusals that honest code meets: they stay out of the kernel's log.
void refuse_quietly(Filter& filter, std::span<const int> shared) {
  // Its flags lie in memory, where a filter cannot see them: glibc falls back to clone.
  filter.add(SCMP_ACT_ERRNO(ENOSYS), "clone3", {});
  filter.add(kRefused, "socket", {});  // gRPC asks what sockets can do
  filter.add(kRefused, "openat", {});  // glibc counts processors, and then does so in another way
  filter.add(kRefused, "ioctl", {masked(1, kInt, TCGETS)});  // is standard output a terminal?
  for (const int fd : shared) {
    const scmp_arg_cmp one = masked(0, kInt, static_cast<scmp_datum_t>(fd));
    for (const unsigned command : {F_SETFL, F_DUPFD_CLOEXEC}) {
      filter.add(kRefused, "fcntl", {one, masked(1, kInt, command)});
    }
    filter.add(kRefused, "shutdown", {one});
    filter.add(kRefused, "ioctl", {one, masked(1, kInt, FIONBIO)});
    filter.add(kRefused, "setsockopt", {one});
    // Each wait for it would be a step of the owner's when it reads.
    filter.add(kRefused, "epoll_ctl", {masked(2, kInt, static_cast<scmp_datum_t>(fd))});
  }
}

void confine_calls(std::span<const int> shared) {
  Filter quiet(SCMP_ACT_ALLOW);
  refuse_quietly(quiet, shared);
  quiet.load(false);
  Filter serving(kRefused);
  for (const char* call : kServing) serving.add(SCMP_ACT_ALLOW, call, {});
  allow_by_argument(serving);
  serving.load(true);
}

/// Files that libraries read at their first use.
void read_what_libraries_need() {
  tzset();
  OPENSSL_init_ssl(0, nullptr);
  static_cast<void>(resident_bytes());
}

}  // namespace

std::string confine_by_landlock() {
  const long version =
      syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) {
    return "this kernel has no Landlock: seccomp alone keeps the front from files, ports and "
           "signals";
  }
  Ruleset all;
  all.handled_access_fs = (1ULL << 13) - 1;  // version 1: every kind of access to files
  if (version >= 2) all.handled_access_fs |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) all.handled_access_fs |= kTruncate;
  if (version >= 4) all.handled_access_net = kBindAndConnect;
  if (version >= 5) all.handled_access_fs |= kIoctlDevice;
  if (version >= 6) all.scoped = kNamesAndSignals;
  const std::size_t size = version >= 6   ? sizeof all
                           : version >= 4 ? offsetof(Ruleset, scoped)
                                          : offsetof(Ruleset, handled_access_net);
  const Descriptor ruleset(static_cast<int>(syscall(SYS_landlock_create_ruleset, &all, size, 0)));
  if (!ruleset) fail("landlock_create_ruleset");
  if (syscall(SYS_landlock_restrict_self, ruleset.get(), 0) != 0) fail("landlock_restrict_self");
  if (version >= 6) return {};
  return "this kernel's Landlock (version " + std::to_string(version) +
         ", not 6) knows no signals: seccomp alone keeps the front from them";
}

std::vector<std::string> confine(std::span<const int> shared) {
  read_what_libraries_need();
  std::vector<std::string> missing;
  if (types_into_terminals()) {
    missing.emplace_back(
        "this kernel lets a program type into its terminal (TIOCSTI): seccomp forbids it to the "
        "front, which has no terminal either");
  }
  if (geteuid() == 0) missing.emplace_back("the front runs as root, which it could not give up");
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) fail("no_new_privs");
  prctl(PR_SET_DUMPABLE, 0, 0, 0, 0);
  if (std::string lack = confine_by_landlock(); !lack.empty()) missing.push_back(std::move(lack));
  confine_calls(shared);
  return missing;
}

}  // namespace haptic::server
