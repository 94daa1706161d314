#include "tests/support/udp_end.hpp"

#include <array>
#include <chrono>

namespace haptic::test {
namespace {

wire::PeerAddress peer(std::uint16_t port) {
  return {.port = port};
}

wire::TimePoint now() {
  return wire::TimePoint(
      std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()));
}

}  // namespace

UdpEnd::UdpEnd(wire::End end, const wire::PathKeys& keys, std::uint16_t server_port)
    : end_({end, keys, {}, [this](const wire::PeerAddress& to, wire::ConstBytes datagram) {
              if (caught_ != nullptr) {
                caught_->assign(datagram.begin(), datagram.end());
              } else if (!cut) {
                send_raw({datagram.begin(), datagram.end()}, to.port);
              }
            }}) {
  if (end == wire::End::kClient) end_.start(peer(server_port), now());
  thread_ = std::thread([this] { run(); });
}

UdpEnd::~UdpEnd() {
  running_ = false;
  thread_.join();
}

void UdpEnd::run() {
  std::array<std::uint8_t, 2000> buffer{};
  while (running_) {
    socket_.wait(1);
    while (const auto received = socket_.receive(buffer)) {
      ++arrivals_;
      if (!cut) take(std::span(buffer).first(received->size), received->from);
    }
    const std::lock_guard lock(mutex_);
    static_cast<void>(end_.step(now()));
  }
}

void UdpEnd::take(wire::ConstBytes bytes, std::uint16_t from) {
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
  static_cast<void>(socket_.send(bytes, port));
}

void UdpEnd::rekey(const wire::PathKeys& keys) {
  const std::lock_guard lock(mutex_);
  end_.rekey(keys);
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
