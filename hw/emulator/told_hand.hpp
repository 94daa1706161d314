#pragma once
/// The hand in an emulated device, told from outside where to bring the finger: a line of text
/// each,
///
///   MCP PIP     both in rad: brings the joints there
///   let-go      hangs loose, touches nothing

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

#include "hw/emulator/rig.hpp"

namespace haptic::hw::emulator {

/// Where to; empty: let go. Throws DeviceError saying what the line is and what is allowed.
[[nodiscard]] std::optional<Eigen::Vector2d> parse_hand(std::string_view line);

class ToldHand {
 public:
  /// `handle`: what to read lines from, without waiting for any; its end changes nothing.
  explicit ToldHand(int handle);
  /// Does what was told since the last call. A line that says nothing known is answered on standard
  /// error.
  void follow(Rig& rig);

 private:
  int handle_;
  std::string pending_{};
};

}  // namespace haptic::hw::emulator
