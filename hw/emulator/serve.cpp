#include "hw/emulator/serve.hpp"

#include <poll.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "hw/thread_priority.hpp"

namespace haptic::hw::emulator {
namespace {

constexpr std::uint64_t kLongestPauseUs = 100000;
constexpr int kPriority = 75;        // a board's firmware does not wait for the host
constexpr std::size_t kRoom = 1024;  // bytes a board's transmit buffer holds

std::uint64_t monotonic_us() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::uint64_t>(t.tv_sec) * 1000000U +
         static_cast<std::uint64_t>(t.tv_nsec) / 1000U;
}

/// Until bytes come, or `until_us` of the clock above.
void wait(const PseudoTerminal& terminal, std::uint64_t until_us) {
  const std::uint64_t now = monotonic_us();
  if (now >= until_us) return;
  const auto left_us = static_cast<long>(until_us - now);
  timespec timeout{left_us / 1000000, (left_us % 1000000) * 1000};
  pollfd polled{terminal.handle(), POLLIN, 0};
  ::ppoll(&polled, 1, &timeout, nullptr);
  if ((polled.revents & POLLHUP) == 0) return;
  // No program has the other end open, so poll() would return at once every time.
  ::clock_nanosleep(CLOCK_MONOTONIC, 0, &timeout, nullptr);
}

/// Bytes that the port has not taken yet; a frame that has begun goes out whole.
class Transmitter {
 public:
  void run(EmulatedBoard& board, PseudoTerminal& terminal) {
    const std::vector<std::uint8_t> fresh = board.take_output();
    pending_.insert(pending_.end(), fresh.begin(), fresh.end());
    if (!terminal.plugged()) pending_.clear();
    const std::size_t taken = terminal.write(pending_);
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(taken));
    board.set_room(kRoom - std::min(kRoom, pending_.size()));
  }

 private:
  std::vector<std::uint8_t> pending_{};
};

}  // namespace

void serve(EmulatedBoard& board, PseudoTerminal& terminal, const std::atomic<bool>& stop,
           const Watcher& watcher) {
  ask_for_priority(kPriority);
  std::uint64_t start = monotonic_us() - board.now_us();
  Transmitter transmitter;
  while (!stop) {
    const std::uint64_t next =
        (board.now_us() / EmulatedBoard::kSampleUs + 1) * EmulatedBoard::kSampleUs;
    wait(terminal, start + next);
    std::uint64_t now = monotonic_us() - start;
    if (now > board.now_us() + kLongestPauseUs) {
      start += now - board.now_us() - kLongestPauseUs;
      now = board.now_us() + kLongestPauseUs;
    }
    const std::vector<std::uint8_t> bytes = terminal.read();
    const std::uint64_t before = board.now_us() / EmulatedBoard::kSampleUs;
    board.advance(now);
    if (!bytes.empty()) board.receive(bytes);  // they woke us just now
    terminal.plug(board.plugged());
    transmitter.run(board, terminal);
    if (watcher && board.now_us() / EmulatedBoard::kSampleUs != before) watcher(board);
  }
}

}  // namespace haptic::hw::emulator
