// Calls that the front must be denied. Each does no harm if it is allowed.

#include <fcntl.h>
#include <linux/capability.h>
#include <linux/fs.h>
#include <linux/futex.h>
#include <linux/sockios.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <iterator>
#include <sstream>
#include <utility>

#include "tests/hostile/front/inside.hpp"

namespace haptic::hostile {
namespace {

/// A call, and the answers that are as good as a denial.
struct Call {
  std::string name;
  std::function<long()> attempt;
  std::vector<int> denials{EPERM, EACCES, ENOSYS};
};
using Calls = std::vector<Call>;

template <typename Value>
Value raw(const Value& value) {
  return value;
}
const char* raw(const std::string& text) {
  return text.c_str();
}

/// The call reached the kernel if it is answered with any error but those of a denial.
template <typename... Values>
Call call(const std::string& name, long number, Values... values) {
  return {name, [=] { return syscall(number, raw(values)...); }};
}

/// A file that is not there is denied as well.
Call file(const std::string& path, int flags) {
  return {"open " + path,
          [=] {
            const int opened = open(path.c_str(), flags | O_NONBLOCK | O_NOCTTY, 0600);
            if (opened >= 0 && (flags & O_CREAT) != 0) unlink(path.c_str());
            return static_cast<long>(opened);
          },
          {EPERM, EACCES, ENOSYS, ENOENT, ENXIO, ENODEV}};
}

Call connects(const std::string& name, bool abstract) {
  return {"connect " + name,
          [=] {
            sockaddr_un to{};
            to.sun_family = AF_UNIX;
            const std::string whole = (abstract ? std::string(1, '\0') : "") + name;
            const std::size_t size = std::min(whole.size(), sizeof to.sun_path);
            std::memcpy(to.sun_path, whole.data(), size);
            const int end = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0);
            const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + size);
            return static_cast<long>(connect(end, reinterpret_cast<sockaddr*>(&to), length));
          },
          {EPERM, EACCES, ENOSYS, EBADF}};  // EBADF: there was no socket
}

void add(Calls& all, Calls more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

Calls on_process(long pid, const std::string& whose) {
  static char byte = 0;
  static const iovec part{&byte, 1};
  static const rlimit64 none{0, 0};
  static siginfo_t nothing{};
  nothing.si_code = SI_QUEUE;
  Calls all{
      call("kill " + whose, SYS_kill, pid, 0),
      call("tkill " + whose, SYS_tkill, pid, 0),
      call("tgkill " + whose, SYS_tgkill, pid, pid, 0),
      call("rt_sigqueueinfo " + whose, SYS_rt_sigqueueinfo, pid, 0, &nothing),
      call("rt_tgsigqueueinfo " + whose, SYS_rt_tgsigqueueinfo, pid, pid, 0, &nothing),
      call("pidfd_open " + whose, SYS_pidfd_open, pid, 0),
      call("ptrace " + whose, SYS_ptrace, PTRACE_SEIZE, pid, 0, 0),
      call("process_vm_readv " + whose, SYS_process_vm_readv, pid, &part, 1, &part, 1, 0),
      call("process_vm_writev " + whose, SYS_process_vm_writev, pid, &part, 1, &part, 1, 0),
      call("kcmp " + whose, SYS_kcmp, pid, pid, 0, 0, 0),
      call("prlimit64 " + whose, SYS_prlimit64, pid, RLIMIT_CORE, &none, 0),
      call("sched_setaffinity " + whose, SYS_sched_setaffinity, pid, 1, &byte),
      call("setpriority " + whose, SYS_setpriority, PRIO_PROCESS, pid, 19),
      call("ioprio_set " + whose, SYS_ioprio_set, 1, pid, 3 << 13),
      call("migrate_pages " + whose, SYS_migrate_pages, pid, 0, 0, 0),
      call("move_pages " + whose, SYS_move_pages, pid, 0, 0, 0, 0, 0),
  };
  const std::string folder = "/proc/" + std::to_string(pid);
  for (const char* name : {"/stat", "/mem", "/maps", "/environ", "/fd", "/root"}) {
    all.push_back(file(folder + name, O_RDONLY));
  }
  return all;
}

Calls on_processes() {
  static const char* const words[] = {"none", nullptr};
  return {call("kill its group", SYS_kill, 0, 0),
          call("kill all", SYS_kill, -1, 0),
          call("pidfd_getfd", SYS_pidfd_getfd, -1, 0, 0),
          call("pidfd_send_signal", SYS_pidfd_send_signal, -1, 0, 0, 0),
          call("process_madvise", SYS_process_madvise, -1, 0, 0, 0, 0),
          call("process_mrelease", SYS_process_mrelease, -1, 0),
          call("ptrace traceme", SYS_ptrace, PTRACE_TRACEME, 0, 0, 0),
          call("execve", SYS_execve, "", words, words + 1),
          call("execveat", SYS_execveat, -1, "", words, words + 1, AT_EMPTY_PATH),
          {"fork",
           [] {
             const long child = syscall(SYS_fork);
             if (child == 0) _exit(0);
             return child;
           }},
          {"vfork",
           [] {
             const long child = vfork();
             if (child == 0) _exit(0);
             return child;
           }},
          {"clone",
           [] {
             const long child = syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0);
             if (child == 0) _exit(0);
             return child;
           }},
          call("clone3", SYS_clone3, 0, 0)};
}

Calls on_scheduling() {
  static const sched_param high{50};
  static std::array<unsigned char, 128> every_core{};
  every_core.fill(0xFF);
  static const rlimit64 more{RLIM64_INFINITY, RLIM64_INFINITY};
  return {call("sched_setaffinity", SYS_sched_setaffinity, 0, every_core.size(), every_core.data()),
          call("sched_setscheduler", SYS_sched_setscheduler, 0, SCHED_FIFO, &high),
          call("sched_setparam", SYS_sched_setparam, 0, &high),
          call("sched_setattr", SYS_sched_setattr, 0, 0, 0),
          call("setpriority", SYS_setpriority, PRIO_PROCESS, 0, -20),
          call("ioprio_set", SYS_ioprio_set, 1, 0, 1 << 13),
          call("more descriptors", SYS_prlimit64, 0, RLIMIT_NOFILE, &more, 0),
          call("more memory", SYS_prlimit64, 0, RLIMIT_DATA, &more, 0),
          call("mlockall", SYS_mlockall, MCL_CURRENT),
          call("membarrier", SYS_membarrier, 1, 0, 0),
          call("sync", SYS_sync)};
}

Calls on_rights() {
  static __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  static const std::array<__user_cap_data_struct, 2> all{{{~0U, ~0U, 0}, {~0U, ~0U, 0}}};
  return {call("capset", SYS_capset, &header, all.data()),
          call("setuid", SYS_setuid, 0),
          call("setgid", SYS_setgid, 0),
          call("setreuid", SYS_setreuid, 0, 0),
          call("setresuid", SYS_setresuid, 0, 0, 0),
          call("setregid", SYS_setregid, 0, 0),
          call("setresgid", SYS_setresgid, 0, 0, 0),
          call("setgroups", SYS_setgroups, 0, 0),
          call("personality", SYS_personality, 0x0040000),
          call("dumpable", SYS_prctl, PR_SET_DUMPABLE, 1, 0, 0, 0),
          call("ptracer", SYS_prctl, PR_SET_PTRACER, PR_SET_PTRACER_ANY, 0, 0, 0),
          call("parent's death", SYS_prctl, PR_SET_PDEATHSIG, 0, 0, 0, 0)};
}

/// Their arguments are wrong, so that the kernel refuses before it does anything.
Calls on_kernel() {
  std::istringstream names(
      "unshare setns mount umount2 pivot_root chroot open_tree move_mount fsopen fspick "
      "mount_setattr bpf perf_event_open userfaultfd io_uring_setup io_uring_enter "
      "io_uring_register keyctl add_key request_key init_module finit_module delete_module "
      "kexec_load swapon swapoff settimeofday clock_settime clock_adjtime iopl ioperm quotactl "
      "acct syslog sethostname vhangup fanotify_init inotify_init1 open_by_handle_at shmget "
      "semget msgget mq_open memfd_secret futex_waitv");
  Calls all{call("memfd_create", SYS_memfd_create, "more", 0)};
  for (std::string name; names >> name;) {
    all.push_back(call(name, seccomp_syscall_resolve_name(name.c_str()), -1, 0, 0, 0, 0, 0));
  }
  return all;
}

Calls on_descriptors() {
  static int on = 1;
  static const f_owner_ex owner{F_OWNER_PID, 1};
  static char key = '\n';
  return {call("F_SETOWN", SYS_fcntl, kLink, F_SETOWN, 1),
          call("F_SETOWN_EX", SYS_fcntl, kLink, F_SETOWN_EX, &owner),
          call("F_SETSIG", SYS_fcntl, kLink, F_SETSIG, SIGKILL),
          call("F_SETFL O_ASYNC", SYS_fcntl, kLink, F_SETFL, O_NONBLOCK | O_ASYNC),
          call("F_SETLEASE", SYS_fcntl, kLink, F_SETLEASE, F_RDLCK),
          call("F_NOTIFY", SYS_fcntl, kLink, F_NOTIFY, 1),
          call("F_SETPIPE_SZ", SYS_fcntl, kLink, F_SETPIPE_SZ, 1 << 20),
          call("SO_LINGER", SYS_setsockopt, kLink, SOL_SOCKET, SO_LINGER, 0, 0),
          call("SO_ATTACH_FILTER", SYS_setsockopt, kLink, SOL_SOCKET, SO_ATTACH_FILTER, 0, 0),
          call("SO_LOCK_FILTER", SYS_setsockopt, kLink, SOL_SOCKET, SO_LOCK_FILTER, 0, 0),
          call("MADV_REMOVE", SYS_madvise, 1, 1, MADV_REMOVE),
          call("MADV_PAGEOUT", SYS_madvise, 1, 1, MADV_PAGEOUT),
          call("FIOASYNC", SYS_ioctl, kLink, FIOASYNC, &on),
          call("FIOSETOWN", SYS_ioctl, kLink, 0x8901, &on),
          call("SIOCSPGRP", SYS_ioctl, kLink, 0x8902, &on),
          call("TIOCSTI", SYS_ioctl, STDERR_FILENO, TIOCSTI, &key),
          call("TIOCLINUX", SYS_ioctl, STDERR_FILENO, TIOCLINUX, &key),
          call("TIOCSCTTY", SYS_ioctl, STDERR_FILENO, TIOCSCTTY, 1)};
}

Calls on_sockets() {
  static sockaddr_in here{AF_INET, htons(9), {htonl(INADDR_LOOPBACK)}, {}};
  static sockaddr_un abstract{AF_UNIX, {}};
  std::memcpy(abstract.sun_path + 1, "hapticd/x", 9);
  return {call("socket UNIX", SYS_socket, AF_UNIX, SOCK_SEQPACKET, 0),
          call("socket NETLINK", SYS_socket, AF_NETLINK, SOCK_RAW, 0),
          call("socket PACKET", SYS_socket, AF_PACKET, SOCK_RAW, 0),
          call("socket ALG", SYS_socket, AF_ALG, SOCK_SEQPACKET, 0),
          call("socket VSOCK", SYS_socket, AF_VSOCK, SOCK_STREAM, 0),
          call("socket raw", SYS_socket, AF_INET, SOCK_RAW, IPPROTO_ICMP),
          call("bind", SYS_bind, -1, &abstract, sizeof abstract),
          call("connect", SYS_connect, -1, &here, sizeof here)};
}

Calls on_files(const std::string& folder) {
  static const std::array<timespec, 2> now{};
  Calls all{call("chmod", SYS_chmod, folder, 0755),
            call("fchmodat", SYS_fchmodat, AT_FDCWD, folder, 0755),
            call("fchmod", SYS_fchmod, STDERR_FILENO, 0644),
            call("chown", SYS_chown, folder, -1, -1),
            call("fchownat", SYS_fchownat, AT_FDCWD, folder, -1, -1, 0),
            call("fchown", SYS_fchown, STDERR_FILENO, -1, -1),
            call("utimensat", SYS_utimensat, AT_FDCWD, folder, now.data(), 0),
            call("setxattr", SYS_setxattr, folder, "user.x", "", 0, 0),
            call("fsetxattr", SYS_fsetxattr, STDERR_FILENO, "user.x", "", 0, 0),
            call("removexattr", SYS_removexattr, folder, "user.x"),
            call("mkdir", SYS_mkdir, folder + "/made", 0700),
            call("mknod", SYS_mknod, folder + "/made", S_IFIFO | 0600, 0),
            call("symlink", SYS_symlink, "/", folder + "/made"),
            call("link", SYS_link, folder + "/log", folder + "/made"),
            call("rename", SYS_rename, folder + "/log", folder + "/made"),
            call("unlink", SYS_unlink, folder + "/scene.textproto"),
            call("truncate", SYS_truncate, folder + "/scene.textproto", 0)};
  for (const char* path : {"/etc/shadow", "/etc/ssl/private", "/root", "/home", "/proc/1/mem",
                           "/proc/kcore", "/proc/sysrq-trigger", "/boot", "/var/log", "/run"}) {
    all.push_back(file(path, O_RDONLY));
  }
  for (const std::string path :
       {"/proc/self/mem", "/proc/self/oom_score_adj", "/proc/sys/kernel/hostname",
        "/proc/sys/kernel/core_pattern", "/dev/ptmx", "/dev/tty", "/dev/tty0", "/dev/mem",
        "/dev/kmsg", "/dev/ttyS0", "/dev/fuse", "/dev/cpu_dma_latency", "/dev/net/tun",
        "/proc/self/fd/2", "/sys/fs/cgroup/cgroup.procs"}) {
    all.push_back(file(path, O_RDWR));
  }
  for (const std::string& place : {folder, std::string("/tmp"), std::string("/dev/shm")}) {
    all.push_back(file(place + "/made", O_RDWR | O_CREAT));
    all.push_back(file(place, O_RDWR | O_TMPFILE));
  }
  for (const std::string name : {"/scene.textproto", "/run-finger.csv", "/log", "/token"}) {
    all.push_back(file(folder + name, O_RDONLY));
  }
  return all;
}

#define HAPTIC_NAMED(name)           \
  std::pair {                        \
#name, static_cast < long>(name) \
  }
constexpr int kNone = kOwn - 1;  ///< no descriptor: EBADF shows that the kernel looked
constexpr long kHighBit = 1L << 32U;

/// Calls that are allowed with other arguments than these.
Calls on_arguments() {
  Calls all;
  const auto each = [&all](long call_number, long first,
                           std::vector<std::pair<const char*, long>> of, auto... rest) {
    for (const auto& [name, value] : of)
      all.push_back(call(name, call_number, first, value, rest...));
  };
  each(SYS_futex, 0,
       {HAPTIC_NAMED(FUTEX_REQUEUE), HAPTIC_NAMED(FUTEX_CMP_REQUEUE), HAPTIC_NAMED(FUTEX_WAKE_OP),
        HAPTIC_NAMED(FUTEX_LOCK_PI), HAPTIC_NAMED(FUTEX_UNLOCK_PI), HAPTIC_NAMED(FUTEX_TRYLOCK_PI),
        HAPTIC_NAMED(FUTEX_WAIT_REQUEUE_PI), HAPTIC_NAMED(FUTEX_CMP_REQUEUE_PI),
        HAPTIC_NAMED(FUTEX_LOCK_PI2), HAPTIC_NAMED(FUTEX_LOCK_PI_PRIVATE),
        HAPTIC_NAMED(FUTEX_LOCK_PI | kHighBit)},
       0, 0, 0, 0);
  each(SYS_fcntl, kNone,
       {HAPTIC_NAMED(F_SETLKW), HAPTIC_NAMED(F_OFD_SETLKW), HAPTIC_NAMED(F_ADD_SEALS),
        HAPTIC_NAMED(F_GETOWN), HAPTIC_NAMED(F_SET_RW_HINT), HAPTIC_NAMED(F_DUPFD),
        HAPTIC_NAMED(F_SETOWN | kHighBit), HAPTIC_NAMED(F_DUPFD_CLOEXEC | kHighBit)},
       1L);
  each(SYS_ioctl, kNone,
       {HAPTIC_NAMED(FIOCLEX),
        HAPTIC_NAMED(FIOQSIZE),
        HAPTIC_NAMED(FICLONE),
        HAPTIC_NAMED(FIBMAP),
        HAPTIC_NAMED(SIOCGIFCONF),
        HAPTIC_NAMED(SIOCATMARK),
        {"SIOCUNIXFILE", 0x89E0},
        HAPTIC_NAMED(TIOCGPTPEER),
        HAPTIC_NAMED(TIOCSETD),
        HAPTIC_NAMED(TIOCSTI | kHighBit)},
       0L);
  each(SYS_setsockopt, kNone, {HAPTIC_NAMED(SOL_TLS), {"SOL_UDP", 17}}, 1L, 0L, 0L);
  for (const auto& [name, option] :
       {HAPTIC_NAMED(SO_BUSY_POLL), HAPTIC_NAMED(SO_PREFER_BUSY_POLL), HAPTIC_NAMED(SO_PEEK_OFF),
        HAPTIC_NAMED(SO_PASSCRED), HAPTIC_NAMED(SO_INCOMING_CPU), HAPTIC_NAMED(SO_RCVBUFFORCE),
        HAPTIC_NAMED(SO_SNDBUF), HAPTIC_NAMED(SO_ZEROCOPY), HAPTIC_NAMED(SO_TXTIME),
        HAPTIC_NAMED(SO_MARK), HAPTIC_NAMED(SO_BROADCAST), HAPTIC_NAMED(SO_BINDTODEVICE),
        HAPTIC_NAMED(SO_RCVBUF | kHighBit)}) {
    all.push_back(call(name, SYS_setsockopt, kNone, SOL_SOCKET, option, 0, 0));
  }
  for (const auto& [name, option] :
       {HAPTIC_NAMED(TCP_REPAIR), HAPTIC_NAMED(TCP_ULP), HAPTIC_NAMED(TCP_CONGESTION),
        HAPTIC_NAMED(TCP_FASTOPEN), HAPTIC_NAMED(TCP_FASTOPEN_CONNECT), HAPTIC_NAMED(TCP_CORK),
        HAPTIC_NAMED(TCP_MD5SIG), HAPTIC_NAMED(TCP_QUEUE_SEQ), HAPTIC_NAMED(TCP_LINGER2)}) {
    all.push_back(call(name, SYS_setsockopt, kNone, IPPROTO_TCP, option, 0, 0));
    all.push_back(
        call(std::string("its ") + name, SYS_getsockopt, kNone, IPPROTO_TCP, option, 0, 0));
  }
  for (const auto& [name, option] :
       {HAPTIC_NAMED(IP_OPTIONS), HAPTIC_NAMED(IP_TRANSPARENT), HAPTIC_NAMED(IP_ADD_MEMBERSHIP)}) {
    all.push_back(call(name, SYS_setsockopt, kNone, IPPROTO_IP, option, 0, 0));
  }
  constexpr long kPeersPidfd = 77, kMapsMemory = 35;  // TCP_ZEROCOPY_RECEIVE
  all.push_back(call("SO_PEERPIDFD", SYS_getsockopt, kLink, SOL_SOCKET, kPeersPidfd, 0, 0));
  all.push_back(call("maps packets", SYS_getsockopt, kNone, IPPROTO_TCP, kMapsMemory, 0, 0));
  for (const auto& [name, option] :
       {HAPTIC_NAMED(PR_SET_MM), HAPTIC_NAMED(PR_SET_TIMERSLACK), HAPTIC_NAMED(PR_SET_SECCOMP),
        HAPTIC_NAMED(PR_SCHED_CORE), HAPTIC_NAMED(PR_SET_CHILD_SUBREAPER),
        HAPTIC_NAMED(PR_SET_IO_FLUSHER), HAPTIC_NAMED(PR_SET_SYSCALL_USER_DISPATCH),
        HAPTIC_NAMED(PR_CAP_AMBIENT), HAPTIC_NAMED(PR_SET_SPECULATION_CTRL),
        HAPTIC_NAMED(PR_MCE_KILL), HAPTIC_NAMED(PR_SET_NAME | kHighBit)}) {
    all.push_back(call(name, SYS_prctl, option, 0, 0, 0, 0));
  }
  for (const auto& [name, advice] :
       {HAPTIC_NAMED(MADV_HWPOISON), std::pair{"MADV_SOFT_OFFLINE", 101L},
        HAPTIC_NAMED(MADV_MERGEABLE), HAPTIC_NAMED(MADV_POPULATE_WRITE), HAPTIC_NAMED(MADV_COLD),
        std::pair{"MADV_COLLAPSE", 25L}}) {
    all.push_back(call(name, SYS_madvise, 1, 1, advice));
  }
  for (const auto& [name, flags] : {HAPTIC_NAMED(MAP_GROWSDOWN), HAPTIC_NAMED(MAP_HUGETLB),
                                    HAPTIC_NAMED(MAP_SHARED_VALIDATE)}) {
    all.push_back(call(name, SYS_mmap, 0, 4096, PROT_READ, flags | MAP_PRIVATE, -1, 0));
  }
  for (const auto& [name, flags] :
       {HAPTIC_NAMED(CLONE_VM | CLONE_VFORK | SIGCHLD), HAPTIC_NAMED(CLONE_PARENT | SIGCHLD),
        HAPTIC_NAMED(CLONE_THREAD | CLONE_PTRACE), HAPTIC_NAMED(CLONE_THREAD | CLONE_NEWUSER)}) {
    all.push_back(call(name, SYS_clone, flags, 0, 0, 0, 0));
  }
  for (const long flags : {long{MSG_FASTOPEN}, long{MSG_FASTOPEN | MSG_DONTWAIT}}) {
    all.push_back(call("sendto MSG_FASTOPEN", SYS_sendto, kNone, 0, 0, flags, 0, 0));
    all.push_back(call("sendmsg MSG_FASTOPEN", SYS_sendmsg, kNone, 0, flags));
  }
  const long own = getpid();
  add(all, {call("its own pid, odd", SYS_tgkill, own | kHighBit, own, 0),
            call("all threads", SYS_tgkill, -1, own, 0),
            call("a signal of its own making", SYS_rt_tgsigqueueinfo, own, own, 0, 0),
            call("its own pidfd", SYS_pidfd_open, own, 0),
            call("prlimit64, odd", SYS_prlimit64, kHighBit, RLIMIT_NOFILE, 0, 0)});
  // Families of calls that move data, wait, or place memory, with no use to a front.
  std::istringstream names(
      "splice tee vmsplice sendfile copy_file_range syncfs fsync sync_file_range fadvise64 "
      "readahead fallocate io_setup io_submit timerfd_create timer_create setitimer alarm "
      "signalfd4 "
      "pipe2 socketpair dup dup2 dup3 sendmmsg recvmmsg statx readlinkat faccessat getdents64 "
      "chdir "
      "mbind set_mempolicy migrate_pages remap_file_pages modify_ldt pkey_alloc mlock munlock "
      "mincore msync seccomp arch_prctl kcmp process_vm_readv name_to_handle_at uselib ioprio_get "
      "getpriority sched_get_priority_max get_robust_list futex_waitv landlock_restrict_self");
  for (std::string name; names >> name;) {
    all.push_back(call(name, seccomp_syscall_resolve_name(name.c_str()), kNone, 0, 0, 0, 0, 0));
  }
  return all;
}

/// Words: the owner, the launcher, the daemon's folder, then names of control sockets; those of the
/// abstract namespace begin with '@'.
void denied_calls(Inside& in) {
  const std::string folder = in.words.size() > 2 ? in.words[2] : "/tmp";
  Calls all = on_process(in.number(0), "owner");
  add(all, on_process(in.number(1), "launcher"));
  add(all, on_process(1, "init"));
  for (Calls more : {on_processes(), on_scheduling(), on_rights(), on_kernel(), on_descriptors(),
                     on_sockets(), on_files(folder), on_arguments()}) {
    add(all, std::move(more));
  }
  for (std::size_t i = 3; i < in.words.size(); ++i) {
    const bool abstract = in.words[i].front() == '@';
    all.push_back(connects(in.words[i].substr(abstract ? 1 : 0), abstract));
  }
  for (const Call& each : all) {
    errno = 0;
    const long got = each.attempt();
    const int why = errno;
    const bool denied = got < 0 && std::count(each.denials.begin(), each.denials.end(), why) > 0;
    answer((denied ? "denied " : "GOT IN ") + each.name + ": " +
           (got < 0 ? strerrorname_np(why) : std::to_string(got)));
  }
}

}  // namespace

const std::vector<Mode> kCallModes{{"calls", denied_calls}};

}  // namespace haptic::hostile
