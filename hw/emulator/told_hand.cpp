#include "hw/emulator/told_hand.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <sstream>

#include "haptic/core/error.hpp"

namespace haptic::hw::emulator {
std::optional<Eigen::Vector2d> parse_hand(const std::string& line) {
  std::istringstream angles(line), words(line);
  Eigen::Vector2d target;
  if (angles >> target[0] >> target[1] && (angles >> std::ws).eof()) return target;
  std::string word;
  if (words >> word && word == "let-go" && (words >> std::ws).eof()) return std::nullopt;
  throw core::DeviceError("hand '" + line + "': must be MCP PIP, two angles in rad, or let-go");
}

ToldHand::ToldHand(int handle) : handle_(handle) {}

void ToldHand::follow(Rig& rig) {
  if (handle_ < 0) return;
  pollfd polled{handle_, POLLIN, 0};
  if (::poll(&polled, 1, 0) <= 0) return;
  std::array<char, 256> bytes{};
  const auto count = ::read(handle_, bytes.data(), bytes.size());
  if (count <= 0) {
    handle_ = -1;
    return;
  }
  pending_.append(bytes.data(), static_cast<std::size_t>(count));
  for (auto end = pending_.find('\n'); end != std::string::npos; end = pending_.find('\n')) {
    try {
      if (const auto target = parse_hand(pending_.substr(0, end))) {
        rig.take_to(*target);
      } else {
        rig.let_go();
      }
    } catch (const core::DeviceError& error) {
      std::fprintf(stderr, "haptic-board-emulator: %s\n", error.what());
    }
    pending_.erase(0, end + 1);
  }
}

}  // namespace haptic::hw::emulator
