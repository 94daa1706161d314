#pragma once
/// The I/O thread of a board: port, protocol, reconnection.

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "haptic/core/tick/mailbox.hpp"
#include "hw/board/board_device.hpp"
#include "hw/board/byte_link.hpp"

namespace haptic::hw {

class BoardDevice::Io {
 public:
  /// Opens the port and starts the thread, which begins to greet. Throws DeviceError.
  Io(std::string port, int baud, board::Expectation expected);
  ~Io() { stop(); }
  Io(const Io&) = delete;
  Io& operator=(const Io&) = delete;

  /// Waits for the first handshake. Throws DeviceError: refused (why), or no answer in
  /// `patience`.
  [[nodiscard]] board::Introduction greeted(core::Duration patience);
  /// Disarms, closes the port, ends the thread; 100 ms at most. Idempotent.
  void stop() noexcept;

  /// Real-time thread: leaves the newest wish and wakes the thread. Never blocks.
  void want(const board::Wanted& wanted) noexcept;
  core::Mailbox<board::BoardReading> readings{};
  /// Posted when a new sample is in `readings`.
  SampleSignal samples{};

  [[nodiscard]] board::HostCounters counters() const;
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }

 private:
  void run();
  void reopen(core::TimePoint at);
  void wait();
  void receive(core::TimePoint at);
  void announce(core::TimePoint at);
  void transmit();
  void lose_link();
  void publish();
  void farewell();

  std::string port_;
  int baud_;
  board::BoardHost host_;
  std::unique_ptr<board::ByteLink> link_;
  std::vector<std::string> notes_;
  int wake_;
  core::Mailbox<board::Wanted> wishes_{};
  std::atomic<bool> stopping_{false};
  bool has_output_{false};      ///< the port did not take everything
  std::uint64_t announced_{0};  ///< BoardReading::seq
  core::TimePoint looked_for_port_{};

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  board::HostCounters counters_{};  // under mutex_, as the next three
  std::optional<board::Introduction> introduction_{};
  std::string refusal_{};

  std::thread thread_;
};

}  // namespace haptic::hw
