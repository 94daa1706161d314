#include "hw/board/board_io.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <random>

#include "haptic/core/error.hpp"
#include "hw/thread_priority.hpp"

namespace haptic::hw {
namespace {

constexpr core::Duration kLookForPort = std::chrono::milliseconds(200);
constexpr core::Duration kFarewell = std::chrono::milliseconds(50);
/// Below the loop (80 by default), above everything that can wait.
constexpr int kPriority = 70;

core::TimePoint now() noexcept {
  return core::TimePoint(std::chrono::steady_clock::now().time_since_epoch());
}

/// Session numbers and nonces must differ from run to run; nothing here is a secret.
std::uint64_t fresh_seed() {
  std::random_device source;
  return (static_cast<std::uint64_t>(source()) << 32) ^ source();
}

}  // namespace

BoardDevice::Io::Io(std::string port, int baud, board::Expectation expected)
    : port_(std::move(port)),
      baud_(baud),
      host_(std::move(expected), fresh_seed()),
      link_(board::open_link(port_, baud_)),
      notes_(link_->notes()),
      wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (wake_ < 0) throw core::DeviceError(std::string("eventfd: ") + std::strerror(errno));
  thread_ = std::thread([this] { run(); });
}

board::Introduction BoardDevice::Io::greeted(core::Duration patience) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, patience, [this] { return introduction_ || !refusal_.empty(); });
  if (introduction_) return *introduction_;
  if (!refusal_.empty()) throw core::DeviceError(port_ + ": board refused: " + refusal_);
  throw core::DeviceError(port_ + ": no answer to HELLO in " +
                          std::to_string(patience / std::chrono::milliseconds(1)) +
                          " ms; must be a board that speaks the protocol of hw/README.md");
}

void BoardDevice::Io::stop() noexcept {
  stopping_ = true;
  const std::uint64_t one = 1;
  static_cast<void>(::write(wake_, &one, sizeof one));
  if (thread_.joinable()) thread_.join();
  if (wake_ >= 0) ::close(wake_);
  wake_ = -1;
}

void BoardDevice::Io::want(const board::Wanted& wanted) noexcept {
  wishes_.publish(wanted);
  // An eventfd that is not waited on takes the write at once: no lock is held, nothing can block.
  const std::uint64_t one = 1;
  static_cast<void>(::write(wake_, &one, sizeof one));
}

board::HostCounters BoardDevice::Io::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

void BoardDevice::Io::run() {
  ask_for_priority(kPriority);
  host_.connect(now());
  while (!stopping_) {
    if (!link_) reopen(now());
    transmit();
    publish();
    wait();
    const core::TimePoint at = now();
    receive(at);
    announce(at);
    if (wishes_.take()) host_.want(wishes_.value(), at);
    host_.poll(at);
  }
  farewell();
}

void BoardDevice::Io::reopen(core::TimePoint at) {
  if (at - looked_for_port_ < kLookForPort) return;
  looked_for_port_ = at;
  try {
    link_ = board::open_link(port_, baud_);
    host_.connect(at);
  } catch (const core::DeviceError&) {
    // The port is not there yet; the next round tries again.
  }
}

void BoardDevice::Io::wait() {
  std::array<pollfd, 2> polled{};
  polled[0] = {wake_, POLLIN, 0};
  polled[1] = {link_ ? link_->handle() : -1,
               static_cast<short>(has_output_ ? POLLIN | POLLOUT : POLLIN), 0};
  constexpr auto kPatience = board::BoardHost::kAgain / std::chrono::milliseconds(1);
  static_cast<void>(::poll(polled.data(), polled.size(), static_cast<int>(kPatience)));
  std::uint64_t ignored = 0;
  if ((polled[0].revents & POLLIN) != 0) {
    static_cast<void>(::read(wake_, &ignored, sizeof ignored));
  }
}

void BoardDevice::Io::receive(core::TimePoint at) {
  std::array<std::uint8_t, 1024> bytes{};
  // A bounded number of reads, so that a flood of bytes does not keep commands from going out.
  for (int reads = 0; reads < 8 && link_; ++reads) {
    const std::ptrdiff_t count = link_->read(bytes);
    if (count < 0) lose_link();
    if (count <= 0) return;
    host_.receive({bytes.data(), static_cast<std::size_t>(count)}, at);
  }
}

/// First of all after reading the port, because a loop that ticks with the samples waits for it.
void BoardDevice::Io::announce(core::TimePoint at) {
  const std::uint64_t newest = host_.reading().seq;
  if (newest == announced_) return;
  announced_ = newest;
  readings.publish(host_.reading());
  samples.post(at);
}

void BoardDevice::Io::transmit() {
  has_output_ = false;
  while (link_ && !host_.output().empty()) {
    const std::ptrdiff_t count = link_->write(host_.output());
    if (count < 0) return lose_link();
    host_.consume(static_cast<std::size_t>(count));
    has_output_ = count == 0;
    if (has_output_) return;
  }
}

void BoardDevice::Io::lose_link() {
  link_.reset();
  host_.disconnect();
  looked_for_port_ = now();
}

void BoardDevice::Io::publish() {
  readings.publish(host_.reading());
  const std::lock_guard lock(mutex_);
  counters_ = host_.counters();
  if (introduction_ || !refusal_.empty()) return;
  if (host_.stage() == board::BoardHost::Stage::kOpen) {
    introduction_ = host_.introduction();
    host_.insist_on(introduction_->identity);
  } else if (host_.stage() == board::BoardHost::Stage::kRefused) {
    refusal_ = host_.refusal();
  } else {
    return;
  }
  changed_.notify_all();
}

/// Tells the board to disarm. If the frame is lost, the board's watchdog stops it.
void BoardDevice::Io::farewell() {
  const core::TimePoint end = now() + kFarewell;
  host_.want({}, now());
  transmit();
  while (link_ && !host_.output().empty() && now() < end) {
    wait();
    transmit();
  }
  link_.reset();
  const std::lock_guard lock(mutex_);
  counters_ = host_.counters();  // with the farewell itself
}

}  // namespace haptic::hw
