#include "tests/support/udp_end.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>

namespace haptic::test {
namespace {

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

wire::PeerAddress peer(std::uint16_t port) {
  wire::PeerAddress answer;
  answer.port = port;
  return answer;
}

wire::TimePoint now() {
  return wire::TimePoint(
      std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()));
}

}  // namespace

UdpEnd::UdpEnd(wire::End end, const wire::PathKeys& keys, std::uint16_t server_port)
    : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)),
      end_({end, keys, {}, [this](const wire::PeerAddress& to, wire::ConstBytes datagram) {
              if (caught_ != nullptr) {
                caught_->assign(datagram.begin(), datagram.end());
              } else if (!cut) {
                send_raw({datagram.begin(), datagram.end()}, to.port);
              }
            }}) {
  sockaddr_in own = loopback(0);
  socklen_t size = sizeof own;
  if (::bind(socket_, reinterpret_cast<sockaddr*>(&own), size) != 0 ||
      ::getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &size) != 0) {
    throw std::runtime_error("no loopback socket");
  }
  port_ = ntohs(own.sin_port);
  if (end == wire::End::kClient) end_.start(peer(server_port), now());
  thread_ = std::thread([this] { run(); });
}

UdpEnd::~UdpEnd() {
  running_ = false;
  thread_.join();
  ::close(socket_);
}

void UdpEnd::run() {
  std::vector<std::uint8_t> buffer(2000);
  while (running_) {
    pollfd waiting{socket_, POLLIN, 0};
    ::poll(&waiting, 1, 1);
    sockaddr_in from{};
    socklen_t length = sizeof from;
    ssize_t size = 0;
    while ((size = ::recvfrom(socket_, buffer.data(), buffer.size(), 0,
                              reinterpret_cast<sockaddr*>(&from), &length)) >= 0) {
      ++arrivals_;
      if (!cut) take({buffer.begin(), buffer.begin() + size}, ntohs(from.sin_port));
    }
    const std::lock_guard lock(mutex_);
    static_cast<void>(end_.step(now()));
  }
}

void UdpEnd::take(const std::vector<std::uint8_t>& bytes, std::uint16_t from) {
  const std::lock_guard lock(mutex_);
  const wire::Received received = end_.receive(bytes, peer(from), now());
  if (received.message) messages_.emplace_back(received.message->begin(), received.message->end());
}

bool UdpEnd::send(const std::string& message) {
  const std::lock_guard lock(mutex_);
  return end_.send({reinterpret_cast<const std::uint8_t*>(message.data()), message.size()});
}

std::vector<std::uint8_t> UdpEnd::seal(const std::string& message) {
  std::vector<std::uint8_t> datagram;
  const std::lock_guard lock(mutex_);
  caught_ = &datagram;
  static_cast<void>(
      end_.send({reinterpret_cast<const std::uint8_t*>(message.data()), message.size()}));
  caught_ = nullptr;
  return datagram;
}

void UdpEnd::send_raw(const std::vector<std::uint8_t>& bytes, std::uint16_t port) {
  const sockaddr_in to = loopback(port);
  static_cast<void>(::sendto(socket_, bytes.data(), bytes.size(), 0,
                             reinterpret_cast<const sockaddr*>(&to), sizeof to));
}

void UdpEnd::rekey(const wire::PathKeys& keys) {
  const std::lock_guard lock(mutex_);
  end_.rekey(keys, wire::OldKeys::kFadeOut);
}

bool UdpEnd::in_use() const {
  const std::lock_guard lock(mutex_);
  return end_.in_use();
}

std::vector<std::string> UdpEnd::messages() const {
  const std::lock_guard lock(mutex_);
  return messages_;
}

wire::LinkCounters UdpEnd::counters() const {
  const std::lock_guard lock(mutex_);
  return end_.counters();
}

}  // namespace haptic::test
