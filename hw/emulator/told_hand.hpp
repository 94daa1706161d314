#pragma once
/// The hand in an emulated device, moved by lines of text:
///
///   MCP PIP     both in rad: brings the joints there
///   let-go      hangs loose, touches nothing

#include <Eigen/Core>
#include <optional>
#include <string>

#include "hw/emulator/rig.hpp"

namespace haptic::hw::emulator {

/// The joints' target; empty: let go. Throws DeviceError naming the line and what is allowed.
[[nodiscard]] std::optional<Eigen::Vector2d> parse_hand(const std::string& line);

class ToldHand {
 public:
  /// `handle`: a file descriptor to read lines from; at its end the hand stays where it is. -1: no
  /// lines.
  explicit ToldHand(int handle);
  /// Follows the lines that came since the last call; does not wait for any. Reports a line it
  /// cannot read on standard error.
  void follow(Rig& rig);

 private:
  int handle_;
  std::string pending_{};
};

}  // namespace haptic::hw::emulator
