// Calls that the front is allowed, with what they can do to the host at their worst.

#include <fcntl.h>
#include <linux/futex.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sched.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/sysinfo.h>
#include <sys/timerfd.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <thread>

#include "tests/hostile/front/inside.hpp"

namespace haptic::hostile {
namespace {

using namespace std::chrono_literals;

/// `work` on as many threads as there may be, at most `most`.
std::vector<std::thread> threads(int most, const std::function<void()>& work) {
  std::vector<std::thread> all;
  try {
    while (static_cast<int>(all.size()) < most) all.emplace_back(work);
  } catch (const std::exception&) {
  }
  return all;
}

void join(std::vector<std::thread>& all) {
  for (std::thread& each : all) each.join();
}

timespec in_a_moment(std::chrono::milliseconds step) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const long every = step.count() * 1'000'000;
  now.tv_nsec = (now.tv_nsec / every + 2) * every;  // the same moment for all
  return {now.tv_sec + now.tv_nsec / 1'000'000'000, now.tv_nsec % 1'000'000'000};
}

/// Timers that end at one moment, each of them watched by epolls: a processor that wakes them all
/// does nothing else.
void timers(const Inside& in) {
  std::vector<int> clocks, watchers;
  for (int fd = 0; clocks.size() < 330 && (fd = timerfd_create(CLOCK_MONOTONIC, 0)) >= 0;) {
    clocks.push_back(fd);
  }
  for (int fd = 0; watchers.size() < 330 && (fd = epoll_create1(0)) >= 0;) watchers.push_back(fd);
  for (const int watcher : watchers) {
    for (const int each : clocks) {
      epoll_event event{EPOLLIN | EPOLLET, {}};
      epoll_ctl(watcher, EPOLL_CTL_ADD, each, &event);
    }
  }
  answer("timers " + std::to_string(clocks.size()) + ", epolls " + std::to_string(watchers.size()));
  while (in.goes_on()) {
    const itimerspec at{{}, in_a_moment(20ms)};
    for (const int each : clocks) timerfd_settime(each, TFD_TIMER_ABSTIME, &at, nullptr);
    std::this_thread::sleep_for(20ms);
  }
  for (const auto* all : {&clocks, &watchers}) {
    for (const int each : *all) close(each);
  }
}

/// Every thread wakes at the same moment.
void alarms(const Inside& in) {
  std::vector<std::thread> all = threads(2000, [&in] {
    while (in.goes_on()) {
      const timespec at = in_a_moment(4ms);
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
    }
  });
  answer("sleepers " + std::to_string(all.size()));
  join(all);
}

/// An object of its own in as many epolls as there may be, some of them in others.
void nests(const Inside& in) {
  const int source = eventfd(0, EFD_NONBLOCK);
  std::vector<int> watchers;
  std::size_t inner = 0;
  for (int fd = 0; watchers.size() < 600 && (fd = epoll_create1(0)) >= 0; watchers.push_back(fd)) {
    epoll_event event{EPOLLIN | EPOLLET, {}};
    epoll_ctl(fd, EPOLL_CTL_ADD, source, &event);
    if (watchers.size() >= 25)
      inner += epoll_ctl(fd, EPOLL_CTL_ADD, watchers[inner % 25], &event) == 0;
  }
  answer("nested " + std::to_string(inner));
  const std::uint64_t one = 1;
  while (in.goes_on()) static_cast<void>(write(source, &one, sizeof one));
  for (const int each : watchers) close(each);
  close(source);
}

/// Word: how it wakes many at once.
void wakes(Inside& in) {
  const std::string how = in.words.empty() ? "timers" : in.words[0];
  if (how == "timers") return timers(in);
  if (how == "alarms") return alarms(in);
  nests(in);
}

void nothing(int) {}

/// Computes, yields, asks and faults on as many threads as it gets; signals them, and lets them
/// begin and end. Word: which of these.
void computes(Inside& in) {
  struct sigaction action {};
  action.sa_handler = nothing;
  sigaction(SIGUSR2, &action, nullptr);
  const std::string how = in.words.empty() ? "all" : in.words[0];
  std::atomic<int> next{0};
  const auto work = [&in, &next, how] {
    constexpr std::size_t kBytes = std::size_t{4} << 20U;
    const int place = how == "spin" ? 0 : next++ % 6;
    auto* const own = static_cast<char*>(
        mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    if (own != MAP_FAILED) madvise(own, kBytes, place % 2 == 0 ? MADV_HUGEPAGE : MADV_NOHUGEPAGE);
    std::array<char, 4096> bytes{};
    struct sysinfo info {};
    rusage use{};
    while (in.goes_on()) {
      for (int i = 0; place == 0 && i < 100'000; ++i) asm volatile("pause");
      if (place == 1) sched_yield();
      if (place == 2) static_cast<void>(getrandom(bytes.data(), bytes.size(), 0));
      if (place == 3) sysinfo(&info), getrusage(RUSAGE_SELF, &use);
      if (place == 4 && own != MAP_FAILED) {
        std::memset(own, 1, kBytes);
        madvise(own, kBytes, MADV_DONTNEED);
      }
      if (place == 5) {
        for (pid_t thread = getpid(); thread < getpid() + 600; ++thread) {
          syscall(SYS_tgkill, getpid(), thread, SIGUSR2);
        }
        std::vector<std::thread> few = threads(4, [] {});
        join(few);
      }
    }
    if (own != MAP_FAILED) munmap(own, kBytes);
  };
  std::vector<std::thread> all = threads(how == "spin" ? 2000 : 60, work);
  answer("computing " + std::to_string(all.size()));
  join(all);
}

/// The pages of the owner as this process has them mapped: what may be done to a mapping, and many
/// waits for the word by which the owner wakes the front.
void owners_mapping(Inside& in) {
  auto* const pages = const_cast<server::OwnersPages*>(owners_pages(in.owner));
  constexpr std::size_t kPage = 4096, kBytes = 64 * kPage;
  void* const moved = mremap(pages, 0, kBytes, MREMAP_MAYMOVE);  // a second mapping of the same
  answer(std::string("second mapping: ") + (moved == MAP_FAILED ? strerrorname_np(errno) : "made"));
  for (void* const each : {static_cast<void*>(pages), moved}) {
    if (each != MAP_FAILED && mprotect(each, kPage, PROT_READ | PROT_WRITE) == 0) {
      answer("GOT IN the owner's pages can be written");
    }
  }
  auto* const word = reinterpret_cast<std::uint32_t*>(&pages->rings);
  // The end of a thread writes here, and wakes who waits.
  struct robust_list_head robust {
    {&robust.list}, 0, nullptr
  };
  robust.list_op_pending = reinterpret_cast<struct robust_list*>(word);
  std::vector<std::thread> all = threads(400, [&] {
    syscall(SYS_set_robust_list, &robust, sizeof robust);
    for (int i = 0; in.goes_on(); ++i) {
      const std::uint32_t now = *static_cast<volatile std::uint32_t*>(word);
      timespec moment{0, 500'000};
      syscall(SYS_futex, word, FUTEX_WAIT_BITSET, now, nullptr, nullptr, 1 << (i % 31));
      if (i % 8 == 0) syscall(SYS_futex, word, FUTEX_WAIT, now, &moment, nullptr, 0);
      if (i % 16 == 0) syscall(SYS_futex, word, FUTEX_WAKE_BITSET, 1000, nullptr, nullptr, 1 << 30);
      if (i % 64 == 0) madvise(pages, kBytes, MADV_DONTNEED);
    }
  });
  answer("waiters " + std::to_string(all.size()));
  while (in.goes_on()) {
    std::this_thread::sleep_for(1ms);
    syscall(SYS_futex, word, FUTEX_WAKE, 1000, nullptr, nullptr, 0);
  }
  for (int i = 0; i < 100; ++i) {
    syscall(SYS_futex, word, FUTEX_WAKE, 1000, nullptr, nullptr, 0);
    std::this_thread::sleep_for(1ms);
  }
  join(all);
}

/// Limits of its own, down to what ends it. Word: which.
void limits(Inside& in) {
  const std::string which = in.words.empty() ? "cpu" : in.words[0];
  const rlimit none{0, 0}, little{1, 1};
  if (which == "files") setrlimit(RLIMIT_NOFILE, &none);
  if (which == "memory") setrlimit(RLIMIT_AS, &little), setrlimit(RLIMIT_DATA, &little);
  if (which == "cpu") setrlimit(RLIMIT_CPU, &little);
  while (in.goes_on()) continue;
}

/// Its first thread ends, and the others stay: a process that looks as if it had ended.
void zombie(Inside& in) {
  struct sigaction action {};
  action.sa_handler = [](int) { syscall(SYS_exit, 0); };
  sigaction(SIGUSR2, &action, nullptr);
  syscall(SYS_tgkill, getpid(), getpid(), SIGUSR2);
  while (in.goes_on()) std::this_thread::sleep_for(5ms);
}

/// Closes what the owner gave it. Word: "link", "samples" or "log".
void closes(Inside& in) {
  const std::string which = in.words.empty() ? "link" : in.words[0];
  if (which == "link") close(kLink);
  if (which == "samples") close(samples_socket(in));
  if (which == "log") close(STDERR_FILENO), close(STDOUT_FILENO), close(STDIN_FILENO);
  while (in.goes_on()) std::this_thread::sleep_for(5ms);
}

/// A TCP socket that was a listener connects, without connect(). Words: ports.
void reaches_out(Inside& in) {
  for (const int fd : in.given) {
    if (!is_tcp(fd, TCP_LISTEN)) continue;
    shutdown(fd, SHUT_RDWR);
    for (std::size_t i = 0; i < in.words.size(); ++i) {
      sockaddr_in to{
          AF_INET, htons(static_cast<std::uint16_t>(in.number(i))), {htonl(INADDR_LOOPBACK)}, {}};
      iovec part{const_cast<char*>("GET"), 3};
      msghdr message{&to, sizeof to, &part, 1, nullptr, 0, 0};
      errno = 0;
      const ssize_t sent = i % 2 == 0 ? sendto(fd, "GET", 3, MSG_FASTOPEN | MSG_NOSIGNAL,
                                               reinterpret_cast<sockaddr*>(&to), sizeof to)
                                      : sendmsg(fd, &message, MSG_FASTOPEN | MSG_NOSIGNAL);
      const int why = errno;
      std::this_thread::sleep_for(20ms);
      const bool connected = is_tcp(fd, TCP_ESTABLISHED) || is_tcp(fd, TCP_SYN_SENT);
      answer((sent >= 0 || connected || why == EINPROGRESS ? "GOT IN connects to port "
                                                           : "denied port ") +
             in.words[i] + ": " + (sent >= 0 ? "sent" : strerrorname_np(why)));
    }
  }
}

/// Leaves bad sockets to the next front: with small buffers, with a datagram that is not finished,
/// and with a copy that a local user holds.
void bequeaths(Inside& in) {
  const int little = 1, millisecond = 1;
  std::vector<int> heirlooms;
  for (const int fd : in.given) {
    sockaddr_storage name{};
    socklen_t size = sizeof name;
    if (getsockname(fd, reinterpret_cast<sockaddr*>(&name), &size) != 0 || fd == kLink) continue;
    heirlooms.push_back(fd);
    fcntl(fd, F_SETFL, O_APPEND);
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &little, sizeof little);
    setsockopt(fd, IPPROTO_TCP, TCP_INQ, &millisecond, sizeof millisecond);
    if (name.ss_family != AF_INET || is_tcp(fd, TCP_LISTEN)) continue;
    sockaddr_in to{AF_INET, htons(9), {htonl(INADDR_LOOPBACK)}, {}};
    sendto(fd, "unfinished", 10, MSG_MORE | MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&to),
           sizeof to);
  }
  heirlooms.push_back(kLink);
  int given = 0;
  for (int fd = kLink + 1; fd < kOwn; ++fd) {
    sockaddr_un name{};
    socklen_t size = sizeof name;
    if (getsockname(fd, reinterpret_cast<sockaddr*>(&name), &size) != 0 ||
        name.sun_family != AF_UNIX || name.sun_path[0] != '/') {
      continue;
    }
    given += send_with(fd, heirlooms, 1) ? 1 : 0;
  }
  answer("gave " + std::to_string(heirlooms.size()) + " sockets to " + std::to_string(given));
}

}  // namespace

const std::vector<Mode> kAllowedModes{{"wakes", wakes},           {"computes", computes},
                                      {"mapped", owners_mapping}, {"limits", limits},
                                      {"zombie", zombie},         {"closes", closes},
                                      {"reaches", reaches_out},   {"bequeaths", bequeaths}};

}  // namespace haptic::hostile
