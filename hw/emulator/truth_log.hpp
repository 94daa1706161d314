#pragma once
/// The true motion of an emulated device, without the errors of its sensors: CSV with a header and
/// a row every 10 ms of the board's time,
///
///   time_s,l_x_m,q_B_rad,force_n    rod, linkage, and the force in the load cell on the linkage
///
/// A thread of its own writes and flushes, so that a slow disk does not silence the board.

#include <condition_variable>
#include <cstdint>
#include <fstream>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "hw/emulator/emulated_board.hpp"

namespace haptic::hw::emulator {

class TruthLog {
 public:
  /// Throws DeviceError if `file` cannot be written.
  explicit TruthLog(const std::string& file);

  /// To be called every millisecond of the board's time.
  void write(const EmulatedBoard& board);

 private:
  void drain(const std::stop_token& stop);

  std::ofstream csv_;
  std::uint64_t next_us_{0};
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::string pending_{};  // under mutex_
  std::jthread thread_;    // writes what is left when it is stopped
};

}  // namespace haptic::hw::emulator
