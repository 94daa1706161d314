// Joins the attacker to the front (inside.hpp). Next to the program, under the name by which it was
// started, lie the pipes `commands` and `answers`: they are opened before the front confines
// itself. A command is a line "MODE SECONDS WORDS...". A file `landlock` there holds the version
// of Landlock that this kernel is to have: 0 stands for none. A file `start` has a word and a
// command that is obeyed before the front serves: "ready", while the front before it may serve, or
// "go", with the sockets.

#include <fcntl.h>
#include <linux/landlock.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "tests/hostile/front/inside.hpp"

namespace haptic::hostile {
namespace {

int commands = -1, answers = -1;
long landlock = -1;          ///< version; negative: this kernel's
std::string when, at_start;  ///< of the file `start`

int kept(const std::filesystem::path& pipe) {
  const int opened = open(pipe.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
  const int high = fcntl(opened, F_DUPFD_CLOEXEC, kOwn);
  close(opened);
  return high;
}

__attribute__((constructor)) void open_pipes() {
  const auto folder = std::filesystem::path(program_invocation_name).parent_path();
  commands = kept(folder / "commands");
  answers = kept(folder / "answers");
  std::ifstream(folder / "landlock") >> landlock;
  std::ifstream start(folder / "start");
  std::getline(start >> when, at_start);
}

void wait_for_good(int) {
  std::array<char, 16> name{};
  prctl(PR_GET_NAME, name.data());
  if (std::strcmp(name.data(), "owner link") != 0) {
    for (;;) pause();
  }
}

/// On a thread of its own: one command does not wait for the one before.
void obey(Inside in, const std::string& line) {
  std::istringstream words(line);
  std::string name, word;
  double seconds = 0.0;
  words >> name >> seconds;
  while (words >> word) in.words.push_back(word);
  in.until = Clock::now() +
             std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  for (const auto* modes : {&kAllowedModes, &kCallModes, &kCrossingModes, &kDescriptorModes,
                            &kLinkModes, &kProcessModes}) {
    for (const Mode& mode : *modes) {
      if (mode.name == name) return mode.run(in);
    }
  }
  answer("unknown mode " + name);
}

Inside inside(server::OwnerLink& owner, Spy& spy) {
  Inside in{owner, spy};
  for (int fd = 0; fd < kOwn; ++fd) {
    if (fcntl(fd, F_GETFD) >= 0) in.given.push_back(fd);
  }
  return in;
}

void start(server::OwnerLink& owner, Spy& spy, const char* stage) {
  if (when == stage) obey(inside(owner, spy), at_start);
}

void listen(server::OwnerLink& owner, const std::shared_ptr<Spy>& spy) {
  const Inside in = inside(owner, *spy);
  std::thread([in, spy] {
    for (;;) {
      pollfd wait{commands, POLLIN, 0};
      poll(&wait, 1, -1);
      std::array<char, 1024> line{};
      const ssize_t got = read(commands, line.data(), line.size());
      if (got <= 0) continue;
      std::thread([in, spy, words = std::string(line.data(), static_cast<std::size_t>(got))] {
        obey(in, words);
        answer("done");
      }).detach();
    }
  }).detach();
}

/// Names a private member to those who ask for it.
template <auto member>
struct Member {
  friend const server::OwnersPages* pages_of(server::OwnerLink& owner) { return owner.*member; }
};
const server::OwnersPages* pages_of(server::OwnerLink& owner);
template struct Member<&server::OwnerLink::pages_>;

}  // namespace

const server::OwnersPages* owners_pages(server::OwnerLink& owner) {
  return pages_of(owner);
}

int samples_socket(const Inside& in) {
  for (const int fd : in.given) {
    sockaddr_un name{};
    socklen_t size = sizeof name;
    const bool named = getsockname(fd, reinterpret_cast<sockaddr*>(&name), &size) == 0 &&
                       size > sizeof name.sun_family;
    if (fd > kLink && name.sun_family == AF_UNIX && !named) return fd;
  }
  return -1;
}

long Inside::number(std::size_t word) const {
  return word < words.size() ? std::atol(words[word].c_str()) : 0;
}

void freeze_the_front() {
  struct sigaction action {};
  action.sa_handler = wait_for_good;
  sigaction(SIGUSR1, &action, nullptr);
  const pid_t self = getpid(), own = gettid();
  for (pid_t thread = self; thread < self + 1000; ++thread) {
    if (thread != own) syscall(SYS_tgkill, self, thread, SIGUSR1);
  }
}

void answer(const std::string& line) {
  const std::string whole = line + "\n";
  pollfd wait{answers, POLLOUT, 0};
  poll(&wait, 1, 1000);
  static_cast<void>(write(answers, whole.data(), whole.size()) < 0);
}

}  // namespace haptic::hostile

// The linker gives the front these instead of its own (--wrap).
extern "C" {
void begin_as_it_is(haptic::server::OwnerLink* owner) __asm__(
    "__real__ZN6haptic6server9OwnerLink5beginEv");
void begin_with_attacker(haptic::server::OwnerLink* owner) __asm__(
    "__wrap__ZN6haptic6server9OwnerLink5beginEv");
using Sockets = std::optional<std::vector<haptic::server::Descriptor>>;
Sockets wait_as_it_is(haptic::server::OwnerLink* owner) __asm__(
    "__real__ZN6haptic6server9OwnerLink11wait_for_goEv");
Sockets wait_with_attacker(haptic::server::OwnerLink* owner) __asm__(
    "__wrap__ZN6haptic6server9OwnerLink11wait_for_goEv");
long syscall_as_it_is(long number, ...) __asm__("__real_syscall");
long syscall_of_old_kernel(long number, long a, long b, long c, long d, long e,
                           long f) __asm__("__wrap_syscall");

/// Runs when the front is ready; the owner may have another one that serves.
Sockets wait_with_attacker(haptic::server::OwnerLink* owner) {
  haptic::hostile::Spy spy;
  haptic::hostile::start(*owner, spy, "ready");
  return wait_as_it_is(owner);
}

/// Runs after the front confined itself, and has its sockets.
void begin_with_attacker(haptic::server::OwnerLink* owner) {
  const auto spy = std::make_shared<haptic::hostile::Spy>();
  owner->connect(spy);
  haptic::hostile::start(*owner, *spy, "go");
  begin_as_it_is(owner);
  haptic::hostile::listen(*owner, spy);
}

long syscall_of_old_kernel(long number, long a, long b, long c, long d, long e, long f) {
  const bool asks = number == SYS_landlock_create_ruleset && c == LANDLOCK_CREATE_RULESET_VERSION;
  if (!asks || haptic::hostile::landlock < 0) return syscall_as_it_is(number, a, b, c, d, e, f);
  if (haptic::hostile::landlock > 0) return haptic::hostile::landlock;
  errno = ENOSYS;
  return -1;
}
}
