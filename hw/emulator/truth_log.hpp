#pragma once
/// What an emulated device really does, as its sensors may not tell it: CSV with a header, a row every
/// 10 ms of the board's time,
///
///   time_s,l_x_m,q_B_rad,force_n    rod, linkage, and the force in the load cell on the linkage

#include <cstdint>
#include <fstream>
#include <string>

#include "hw/emulator/emulated_board.hpp"

namespace haptic::hw::emulator {

class TruthLog {
 public:
  /// Throws DeviceError where `file` cannot be written.
  explicit TruthLog(const std::string& file);
  /// To be called every millisecond of the board's time. Every row is flushed.
  void write(const EmulatedBoard& board);

 private:
  std::ofstream csv_;
  std::uint64_t next_us_{0};
};

}  // namespace haptic::hw::emulator
