// The front as a process: memory, threads, noise, its log, its end.

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <thread>

#include "tests/hostile/front/inside.hpp"

namespace haptic::hostile {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMb = std::size_t{1} << 20U;
constexpr std::size_t kMuch = 1200;  ///< MB: more than a front may have
constexpr std::size_t kPerMb = 40;   ///< threads

/// `take` takes one MB, and keeps it; false: there is no more.
void take_all(const char* what, const Inside& in, const std::function<bool()>& take) {
  std::size_t got = 0;
  while (got < kMuch && in.goes_on() && take()) ++got;
  answer(std::string(what) + " " + std::to_string(got));
}

bool fill(int fd, std::size_t bytes) {
  static const std::vector<char> zeros(kMb);
  fcntl(fd, F_SETFL, O_NONBLOCK);
  while (bytes > 0) {
    const ssize_t put = write(fd, zeros.data(), std::min(bytes, zeros.size()));
    if (put <= 0) return false;
    bytes -= static_cast<std::size_t>(put);
  }
  return true;
}

bool touched(void* memory) {
  if (memory == MAP_FAILED || memory == nullptr) return false;
  std::memset(memory, 1, kMb);
  return true;
}

void* mapped(int flags, int fd) {
  return mmap(nullptr, kMb, PROT_READ | PROT_WRITE, flags, fd, 0);
}

int sleep_for_good(void*) {
  for (;;) {
    const timespec long_time{1'000'000, 0};
    syscall(SYS_nanosleep, &long_time, nullptr);
  }
}

/// Threads that have next to no stack: the kernel's memory for one is 20 KB and more.
bool idle_threads(std::size_t count) {
  constexpr int kFlags = CLONE_VM | CLONE_FS | CLONE_FILES | CLONE_SIGHAND | CLONE_THREAD;
  constexpr std::size_t kStack = 2048;
  auto* const stacks = static_cast<char*>(std::malloc(count * kStack));
  for (std::size_t i = 1; i <= count && stacks != nullptr; ++i) {
    if (clone(sleep_for_good, stacks + i * kStack, kFlags, nullptr) < 0) return false;
  }
  return stacks != nullptr;
}

/// Memory that no limit on data counts. Word: which kind.
void memory(Inside& in) {
  const std::string kind = in.words.empty() ? "data" : in.words[0];
  take_all(kind.c_str(), in, [&]() -> bool {
    if (kind == "memfd") return fill(memfd_create("more", 0), kMb);
    if (kind == "shared") return touched(mapped(MAP_SHARED | MAP_ANONYMOUS, -1));
    if (kind == "private") return touched(mapped(MAP_PRIVATE | MAP_ANONYMOUS, -1));
    // Counted as a stack.
    if (kind == "growing") return touched(mapped(MAP_PRIVATE | MAP_ANONYMOUS | MAP_GROWSDOWN, -1));
    if (kind == "threads") return idle_threads(kPerMb);
    if (kind == "tmpfs") return fill(open("/dev/shm", O_TMPFILE | O_RDWR, 0600), kMb);
    if (kind == "shmget") {
      const int id = shmget(IPC_PRIVATE, kMb, IPC_CREAT | 0600);
      void* const at = shmat(id, nullptr, 0);
      shmctl(id, IPC_RMID, nullptr);
      return at != reinterpret_cast<void*>(-1) && touched(at);
    }
    std::array<int, 2> ends{};
    if (kind == "pipes") {
      if (pipe2(ends.data(), O_NONBLOCK) != 0) return false;
      fcntl(ends[1], F_SETPIPE_SZ, kMb);
      return fill(ends[1], kMb);
    }
    const int most = 1 << 30;  // sockets: the kernel takes what is allowed of it
    for (int i = 0; i < 8; ++i) {
      if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0) return false;
      setsockopt(ends[0], SOL_SOCKET, SO_SNDBUF, &most, sizeof most);
      static_cast<void>(fill(ends[0], kMb / 8));
    }
    return true;
  });
  while (in.goes_on()) std::this_thread::sleep_for(5ms);
}

/// Makes as many threads as it can, and sends descriptors into its own sockets: both count against
/// the user, whose process the owner may be.
void users_limits(Inside& in) {
  std::vector<std::thread> all;
  std::array<int, 2> ends{};
  try {
    while (all.size() < 20'000) {
      all.emplace_back([&in] {
        while (in.goes_on()) std::this_thread::sleep_for(50ms);
      });
    }
  } catch (const std::exception&) {
  }
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int) * 253)> control{};
  int flying = 0;
  while (in.goes_on() && socketpair(AF_UNIX, SOCK_DGRAM, 0, ends.data()) == 0) {
    char byte = 0;
    iovec part{&byte, 1};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* const header = CMSG_FIRSTHDR(&message);
    *header = {CMSG_LEN(sizeof(int) * 253), SOL_SOCKET, SCM_RIGHTS};
    std::fill_n(reinterpret_cast<int*>(CMSG_DATA(header)), 253, ends[0]);
    if (sendmsg(ends[0], &message, MSG_DONTWAIT) < 0) break;
    flying += 253;
  }
  answer("threads " + std::to_string(all.size()) + ", descriptors " + std::to_string(flying));
  for (std::thread& each : all) each.join();
}

/// Calls that make every core of the host do something.
void noise(Inside& in) {
  std::vector<std::thread> all;
  for (int i = 0; i < 4; ++i) {
    all.emplace_back([&in] {
      void* const own = mapped(MAP_SHARED | MAP_ANONYMOUS, -1);
      while (in.goes_on()) {
        syscall(SYS_sync);
        for (const int command : {1, 2, 8, 32}) syscall(SYS_membarrier, command, 0, 0);
        for (int n = 0; n < 100; ++n) {
          mprotect(own, kMb, n % 2 == 0 ? PROT_NONE : PROT_READ | PROT_WRITE);
        }
        madvise(own, kMb, MADV_REMOVE);
      }
    });
  }
  for (std::thread& each : all) each.join();
}

/// Escapes, a forged line, and 64 MB for the log. Word: "shut" ends with a shutdown of it.
void log(Inside& in) {
  fcntl(STDERR_FILENO, F_SETFL, O_WRONLY | O_NONBLOCK);
  const std::string line = "\x1b[31mred\x9b\x07\n2026 forged line \xe2\x80\xae\n";
  const std::string much(60'000, 'x');
  for (std::size_t sent = 0; in.goes_on() && sent < 64 * kMb;) {
    for (const std::string& each : {line, much}) {
      const ssize_t put = write(STDERR_FILENO, each.data(), each.size());
      if (put > 0) sent += static_cast<std::size_t>(put);
    }
  }
  if (in.words.empty()) return;
  shutdown(STDERR_FILENO, SHUT_RDWR);
  static_cast<void>(ftruncate(STDERR_FILENO, 0));
}

int overflow(int depth) {
  std::array<volatile char, 4096> frame{};
  frame[0] = static_cast<char>(depth);
  return depth < 0 ? 0 : overflow(depth + 1) + frame[0];
}

/// Word: how.
void dies(Inside& in) {
  const std::string how = in.words.empty() ? "exit" : in.words[0];
  if (how == "exit") _exit(0);
  if (how == "abort") std::abort();
  if (how == "overflow") _exit(overflow(0));
  if (how == "stop") raise(SIGSTOP);
  if (how == "hang") freeze_the_front();
  while (in.goes_on()) std::this_thread::sleep_for(5ms);
}

}  // namespace

const std::vector<Mode> kProcessModes{
    {"memory", memory}, {"users", users_limits}, {"noise", noise}, {"log", log}, {"dies", dies}};

}  // namespace haptic::hostile
