#pragma once
/// What an emulated device really does, as its sensors may not tell it: CSV with a header, a row
/// every 10 ms of the board's time,
///
///   time_s,l_x_m,q_B_rad,force_n    rod, linkage, and the force in the load cell on the linkage
///
/// A thread of its own writes and flushes: a disk that takes its time is no silence of the board.

#include <condition_variable>
#include <cstdint>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>

#include "hw/emulator/emulated_board.hpp"

namespace haptic::hw::emulator {

class TruthLog {
 public:
  /// Throws DeviceError where `file` cannot be written.
  explicit TruthLog(const std::string& file);
  /// Writes what is left.
  ~TruthLog();
  TruthLog(const TruthLog&) = delete;
  TruthLog& operator=(const TruthLog&) = delete;

  /// To be called every millisecond of the board's time.
  void write(const EmulatedBoard& board);

 private:
  void drain();

  std::ofstream csv_;
  std::uint64_t next_us_{0};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string pending_{};  // under mutex_, as the next
  bool closing_{false};
  std::thread thread_;
};

}  // namespace haptic::hw::emulator
