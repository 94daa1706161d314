// Both processes hold these: descriptors and their open file descriptions, pages, sockets.

#include <fcntl.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <thread>

#include "tests/hostile/front/inside.hpp"

namespace haptic::hostile {
namespace {

using namespace std::chrono_literals;

void pause_until_over(const Inside& in) {
  while (in.goes_on()) std::this_thread::sleep_for(5ms);
}

bool is_socket(int fd) {
  struct stat status {};
  return fstat(fd, &status) == 0 && S_ISSOCK(status.st_mode);
}

/// Whoever reads or writes one of them on the other side waits.
void make_blocking(const Inside& in) {
  for (const int fd : in.given) fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) & ~O_NONBLOCK);
}

/// Word: "deaf": what rings at the owner's is cut off as well.
void blocking(Inside& in) {
  make_blocking(in);
  std::array<int, 2> ends{};
  const bool deaf = !in.words.empty() && pipe2(ends.data(), O_NONBLOCK | O_CLOEXEC) == 0;
  for (const int fd : in.given) {
    struct stat status {};
    const bool anonymous = fstat(fd, &status) == 0 && (status.st_mode & S_IFMT) == 0;
    if (deaf && anonymous) dup2(ends[1], fd);
  }
  pause_until_over(in);
}

/// A signal to the owner, from what the kernel tells of a descriptor. Words: processes.
void signals_by_descriptor(Inside& in) {
  std::vector<int> all = in.given;
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_NONBLOCK | O_CLOEXEC) == 0) all.insert(all.end(), {ends[0], ends[1]});
  while (in.goes_on()) {
    for (std::size_t word = 0; word < in.words.size(); ++word) {
      const int pid = static_cast<int>(in.number(word));
      const f_owner_ex to{F_OWNER_PID, pid};
      for (const int fd : all) {
        int on = 1;
        fcntl(fd, F_SETSIG, SIGKILL);
        if (fcntl(fd, F_SETOWN, pid) != 0 && fcntl(fd, F_SETOWN_EX, &to) != 0) {
          ioctl(fd, FIOSETOWN, &pid);
        }
        if (fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_ASYNC) != 0) ioctl(fd, FIOASYNC, &on);
      }
      char byte = 0;
      static_cast<void>(write(ends[1], "x", 1) + read(ends[0], &byte, 1));
      std::this_thread::sleep_for(20ms);
    }
  }
}

void locks(Inside& in) {
  for (const int fd : in.given) {
    struct flock whole {};
    whole.l_type = F_WRLCK;
    flock(fd, LOCK_EX | LOCK_NB);
    fcntl(fd, F_OFD_SETLK, &whole);
    fcntl(fd, F_SETLK, &whole);
    fcntl(fd, F_SETLEASE, F_WRLCK);
  }
  pause_until_over(in);
}

void tell(const char* what, int fd, int result) {
  const char* const how = result == 0 ? "done" : strerrorname_np(errno);
  answer(std::string(what) + " of " + std::to_string(fd) + ": " + how);
}

/// Word: "shut", "filter", "backlog" or "link". Says how each try ended. The front ends then, and
/// the next gets the same sockets.
void sockets(Inside& in) {
  const std::string how = in.words.empty() ? "shut" : in.words[0];
  sock_filter nothing{BPF_RET | BPF_K, 0, 0, 0};
  const sock_fprog drop{1, &nothing};
  const sockaddr_in nowhere{AF_INET, htons(9), {htonl(INADDR_LOOPBACK)}, {}};
  const int hour = 3600, little = 1;
  const auto set = [](int fd, int level, int name, const auto& value) {
    return setsockopt(fd, level, name, &value, sizeof value);
  };
  if (how == "link") tell("shutdown", kLink, shutdown(kLink, SHUT_RDWR));
  for (const int fd : in.given) {
    if (fd == kLink || !is_socket(fd)) continue;
    if (how == "shut") {
      tell("shutdown", fd, shutdown(fd, SHUT_RDWR));
      tell("copy", fd, std::min(fcntl(fd, F_DUPFD_CLOEXEC, 0), 0));
      tell("flags", fd, fcntl(fd, F_SETFL, 0));
      tell("connect", fd, connect(fd, reinterpret_cast<const sockaddr*>(&nowhere), sizeof nowhere));
    } else if (how == "filter") {
      tell("filter", fd, set(fd, SOL_SOCKET, SO_ATTACH_FILTER, drop));
      tell("lock", fd, set(fd, SOL_SOCKET, SO_LOCK_FILTER, little));
    } else if (how == "backlog") {
      tell("listen", fd, ::listen(fd, 0));
      tell("defer", fd, set(fd, IPPROTO_TCP, TCP_DEFER_ACCEPT, hour));
      tell("buffer", fd, set(fd, SOL_SOCKET, SO_RCVBUF, little));
      tell("hops", fd, set(fd, IPPROTO_IP, IP_TTL, little));
    }
  }
  if (how != "link") _exit(9);
  pause_until_over(in);
}

/// Watches what the owner gave, and copies of the link, by as many epolls as there may be: whoever
/// wakes the link's end up, and that is the owner, walks them all.
void epolls(Inside& in) {
  std::vector<int> copies = in.given;
  for (int copy = 0; copies.size() < 1500 && (copy = dup(kLink)) >= 0;) copies.push_back(copy);
  std::size_t watches = 0;
  for (int watcher = 0; in.goes_on() && (watcher = epoll_create1(0)) >= 0;) {
    for (const int copy : copies) {
      epoll_event event{EPOLLIN | EPOLLOUT | EPOLLET, {}};
      if (epoll_ctl(watcher, EPOLL_CTL_ADD, copy, &event) == 0 && is_socket(copy)) ++watches;
    }
  }
  answer("watches " + std::to_string(watches));
  while (in.goes_on()) {
    in.owner.say({});
    std::this_thread::sleep_for(5ms);
  }
}

/// 253 ends of a pipe with every message.
void descriptors_to_owner(Inside& in) {
  std::array<int, 2> ends{};
  static_cast<void>(pipe(ends.data()));
  const std::vector<int> many(253, ends[0]);
  std::uint64_t sent = 0;
  while (in.goes_on()) {
    if (send_with(kLink, many, sizeof(server::FrontMessage))) ++sent;
    std::this_thread::sleep_for(1ms);
  }
  answer("sent " + std::to_string(sent));
}

/// Connections whose close waits for a peer that does not read: the last to close them is the
/// owner.
void lingering(Inside& in) {
  std::vector<char> junk(1 << 16);
  const linger patience{1, 60};
  int given_away = 0;
  for (int fd = kLink + 1; fd < kOwn; ++fd) {
    if (!is_tcp(fd, TCP_ESTABLISHED)) continue;
    while (send(fd, junk.data(), junk.size(), MSG_DONTWAIT | MSG_NOSIGNAL) > 0) continue;
    setsockopt(fd, SOL_SOCKET, SO_LINGER, &patience, sizeof patience);
    if (send_with(kLink, {fd}, sizeof(server::FrontMessage))) ++given_away;
    close(fd);
  }
  answer("gave away " + std::to_string(given_away));
  pause_until_over(in);
}

}  // namespace

bool is_tcp(int fd, std::uint8_t state) {
  tcp_info info{};
  socklen_t size = sizeof info;
  return getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 && info.tcpi_state == state;
}

bool send_with(int socket, const std::vector<int>& descriptors, std::size_t bytes) {
  static std::array<char, 8192> zeros{};
  iovec part{zeros.data(), bytes};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int) * 253)> control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = CMSG_SPACE(sizeof(int) * descriptors.size());
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(sizeof(int) * descriptors.size());
  std::copy(descriptors.begin(), descriptors.end(), reinterpret_cast<int*>(CMSG_DATA(header)));
  return sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0;
}

const std::vector<Mode> kDescriptorModes{{"blocking", blocking},  {"setown", signals_by_descriptor},
                                         {"locks", locks},        {"epolls", epolls},
                                         {"sockets", sockets},    {"rights", descriptors_to_owner},
                                         {"lingering", lingering}};

}  // namespace haptic::hostile
