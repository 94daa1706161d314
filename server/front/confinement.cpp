#include "server/front/confinement.hpp"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#include "haptic/core/error.hpp"
#include "server/base/descriptor.hpp"

namespace haptic::server {
namespace {

// Not in Debian 12's <linux/landlock.h>, which knows version 2.
constexpr std::uint64_t kTruncate = 1ULL << 14;
constexpr std::uint64_t kIoctlDevice = 1ULL << 15;
constexpr std::uint64_t kScopeSignal = 1ULL << 1;
struct Ruleset {
  std::uint64_t handled_access_fs{0};
  std::uint64_t handled_access_net{0};
  std::uint64_t scoped{0};
};

constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t kReadFile = LANDLOCK_ACCESS_FS_READ_FILE;

[[noreturn]] void fail(const char* what) {
  throw core::TransportError(std::string("confinement of the front: ") + what + ": " +
                             std::strerror(errno));
}

/// Allows to read `place` and what lies in it.
void allow(int ruleset, int place) {
  struct stat status {};
  if (fstat(place, &status) != 0) return;  // what is not there needs no permission
  const landlock_path_beneath_attr rule{S_ISDIR(status.st_mode) ? kRead : kReadFile, place};
  if (syscall(SYS_landlock_add_rule, ruleset, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) != 0) {
    fail("landlock_add_rule");
  }
}

void confine_files(int folder, std::vector<std::string>& missing) {
  const long version =
      syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) {
    missing.emplace_back("this kernel has no Landlock: the front may open every file of its user");
    return;
  }
  Ruleset all;
  all.handled_access_fs = (1ULL << 13) - 1;  // version 1: every kind of access to files
  if (version >= 2) all.handled_access_fs |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) all.handled_access_fs |= kTruncate;
  if (version >= 5) all.handled_access_fs |= kIoctlDevice;
  if (version >= 6) all.scoped = kScopeSignal;
  const std::size_t size = version >= 6 ? sizeof all : sizeof all.handled_access_fs;
  const Descriptor ruleset(static_cast<int>(syscall(SYS_landlock_create_ruleset, &all, size, 0)));
  if (!ruleset) fail("landlock_create_ruleset");
  for (const char* system :
       {"/usr", "/lib", "/lib64", "/etc", "/proc/self", "/proc/sys", "/sys/devices/system/cpu",
        "/sys/fs/cgroup", "/dev/null", "/dev/urandom", "/run/systemd/resolve"}) {
    allow(ruleset.get(), Descriptor(open(system, O_PATH | O_CLOEXEC)).get());
  }
  allow(ruleset.get(), folder);
  if (syscall(SYS_landlock_restrict_self, ruleset.get(), 0) != 0) fail("landlock_restrict_self");
}

void confine_calls() {
  const std::unique_ptr<void, decltype(&seccomp_release)> filter(seccomp_init(SCMP_ACT_ALLOW),
                                                                 &seccomp_release);
  if (!filter) fail("seccomp_init");
  const auto deny = [&](int call, int error, auto... conditions) {
    if (call < 0) return;  // not on this machine
    constexpr unsigned kConditions = sizeof...(conditions);
    const std::array<scmp_arg_cmp, kConditions + 1> tests{conditions..., scmp_arg_cmp{}};
    const int result =
        seccomp_rule_add_array(filter.get(), SCMP_ACT_ERRNO(static_cast<unsigned>(error)), call,
                               kConditions, tests.data());
    if (result != 0) {
      errno = -result;
      fail("seccomp_rule_add");
    }
  };
  const auto self = static_cast<scmp_datum_t>(getpid());
  // Its own threads it may signal, which abort() does.
  deny(SCMP_SYS(kill), EPERM, SCMP_A0(SCMP_CMP_NE, self));
  deny(SCMP_SYS(tgkill), EPERM, SCMP_A0(SCMP_CMP_NE, self));
  deny(SCMP_SYS(rt_sigqueueinfo), EPERM, SCMP_A0(SCMP_CMP_NE, self));
  deny(SCMP_SYS(rt_tgsigqueueinfo), EPERM, SCMP_A0(SCMP_CMP_NE, self));
  // Threads yes, processes no. clone3's flags lie in memory, where a filter cannot see them: glibc
  // falls back to clone.
  deny(SCMP_SYS(clone3), ENOSYS);
  deny(SCMP_SYS(clone), EPERM, SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, 0));
  for (const char* name : {"tkill",
                           "fork",
                           "vfork",
                           "execve",
                           "execveat",
                           "ptrace",
                           "process_vm_readv",
                           "process_vm_writev",
                           "process_madvise",
                           "kcmp",
                           "pidfd_open",
                           "pidfd_send_signal",
                           "pidfd_getfd",
                           "sched_setscheduler",
                           "sched_setparam",
                           "sched_setattr",
                           "setpriority",
                           "ioprio_set",
                           "mknod",
                           "mknodat",
                           "open_by_handle_at",
                           "mount",
                           "umount2",
                           "pivot_root",
                           "chroot",
                           "unshare",
                           "setns",
                           "bpf",
                           "perf_event_open",
                           "userfaultfd",
                           "io_uring_setup",
                           "keyctl",
                           "add_key",
                           "request_key",
                           "init_module",
                           "finit_module",
                           "kexec_load",
                           "reboot",
                           "swapon",
                           "swapoff",
                           "settimeofday",
                           "clock_settime",
                           "adjtimex",
                           "iopl",
                           "ioperm",
                           "setuid",
                           "setgid",
                           "setreuid",
                           "setresuid",
                           "quotactl",
                           "acct"}) {
    const int call = seccomp_syscall_resolve_name(name);
    if (call == __NR_SCMP_ERROR) {
      throw core::TransportError(std::string("confinement of the front: no system call ") + name);
    }
    deny(call, EPERM);
  }
  deny(SCMP_SYS(prlimit64), EPERM, SCMP_A0(SCMP_CMP_NE, 0));
  const int result = seccomp_load(filter.get());
  if (result != 0) {
    errno = -result;
    fail("seccomp_load");
  }
}

}  // namespace

std::vector<std::string> confine(int folder) {
  std::vector<std::string> missing;
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) fail("no_new_privs");
  prctl(PR_SET_DUMPABLE, 0, 0, 0, 0);
  confine_files(folder, missing);
  confine_calls();
  return missing;
}

}  // namespace haptic::server
