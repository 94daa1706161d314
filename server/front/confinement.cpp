#include "server/front/confinement.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <linux/seccomp.h>
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
                                "set_robust_list",
                                "shutdown",
                                "sigaltstack",
                                "socket",
                                "sysinfo",
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
  // A mapping that grows down counts as a stack, and huge pages are the host's.
  allow("mmap", masked(2, PROT_EXEC, 0),
        masked(3, MAP_TYPE | MAP_GROWSDOWN | MAP_HUGETLB, MAP_PRIVATE));
  allow("mprotect", masked(2, PROT_EXEC, 0));
  for (const int advice :
       {MADV_DONTNEED, MADV_FREE, MADV_HUGEPAGE, MADV_NOHUGEPAGE, MADV_DONTDUMP}) {
    allow("madvise", is(2, static_cast<scmp_datum_t>(advice)));
  }
  // A listener that was shut down could connect by it; and what is not finished waits in the socket
  // for the next front's.
  allow("sendto", masked(3, MSG_FASTOPEN | MSG_MORE, 0));
  allow("sendmsg", masked(2, MSG_FASTOPEN | MSG_MORE, 0));
  for (const unsigned command : {F_GETFL, F_GETFD, F_SETFD, F_DUPFD_CLOEXEC}) {
    allow("fcntl", is(1, command));
  }
  allow("fcntl", is(1, F_SETFL), masked(2, O_ASYNC, 0));
  for (const unsigned request : {FIONBIO, SIOCINQ, SIOCOUTQ, TCGETS})
    allow("ioctl", is(1, request));
  allow("prctl", is(0, PR_SET_NAME));
  // For confine_sockets(), which refuses both.
  allow("prctl", is(0, PR_SET_NO_NEW_PRIVS));
  allow("seccomp", is(0, SECCOMP_SET_MODE_FILTER));
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

/// Refusals of everything that the owner, or a later front, would notice of one of `shared`.
void refuse_changes(Filter& filter, std::span<const int> shared) {
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

/// Refusals that honest code meets: they stay out of the kernel's log.
void refuse_quietly(Filter& filter) {
  // Its flags lie in memory, where a filter cannot see them: glibc falls back to clone.
  filter.add(SCMP_ACT_ERRNO(ENOSYS), "clone3", {});
  filter.add(kRefused, "socket", {});  // gRPC asks what sockets can do
  filter.add(kRefused, "openat", {});  // glibc counts processors, and then does so in another way
  // Asio does without. Many that end at once, each watched by many epolls, keep a processor from
  // everything else for as long as the wake-ups take.
  filter.add(kRefused, "timerfd_create", {});
  filter.add(kRefused, "ioctl", {masked(1, kInt, TCGETS)});  // is standard output a terminal?
}

void confine_calls(std::span<const int> shared) {
  Filter quiet(SCMP_ACT_ALLOW);
  refuse_quietly(quiet);
  refuse_changes(quiet, shared);
  quiet.load(false);
  Filter serving(kRefused);
  for (const char* call : kServing) serving.add(SCMP_ACT_ALLOW, call, {});
  allow_by_argument(serving);
#ifdef __SANITIZE_ADDRESS__
  // The sanitizer of undefined behaviour asks by a pipe if there is memory where an object should
  // be: without an answer it takes every object for a wrong one.
  for (const char* call : {"pipe", "pipe2"}) serving.add(SCMP_ACT_ALLOW, call, {});
#endif
  serving.load(true);
}

/// Files that libraries read at their first use. That of OpenSSL says how TLS is to be, and costs
/// 2 MB.
void read_what_libraries_need(UsesTls uses_tls) {
  tzset();
  if (uses_tls == UsesTls::kYes) {
    OPENSSL_init_ssl(0, nullptr);
  } else {
    OPENSSL_init_crypto(OPENSSL_INIT_NO_LOAD_CONFIG, nullptr);
  }
  static_cast<void>(resident_bytes());
}

}  // namespace

std::vector<std::string> confine(UsesTls uses_tls, std::span<const int> shared) {
  read_what_libraries_need(uses_tls);
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

void confine_sockets(std::span<const int> sockets) {
  Filter last(SCMP_ACT_ALLOW);
  refuse_changes(last, sockets);
  last.add(kRefused, "seccomp", {});
  last.add(kRefused, "prctl", {masked(0, kInt, PR_SET_NO_NEW_PRIVS)});
  last.load(false);
}

}  // namespace haptic::server
