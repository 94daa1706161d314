#include "hw/emulator/told_hand.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "haptic/core/error.hpp"

namespace haptic::hw::emulator {
namespace {

constexpr std::string_view kBlank = " \t\r";

/// The first word, taken away from `line`.
std::string_view word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
  const std::string_view found = line.substr(0, line.find_first_of(kBlank));
  line.remove_prefix(found.size());
  return found;
}

bool to_angle(std::string_view text, double& value) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc{} && result.ptr == text.data() + text.size() &&
         std::isfinite(value);
}

}  // namespace

std::optional<Eigen::Vector2d> parse_hand(std::string_view line) {
  std::string_view rest = line;
  const std::string_view first = word(rest), second = word(rest);
  if (first == "let-go" && second.empty()) return std::nullopt;
  Eigen::Vector2d target;
  if (!to_angle(first, target[0]) || !to_angle(second, target[1]) || !word(rest).empty()) {
    throw core::DeviceError("hand '" + std::string(line) +
                            "': must be MCP PIP, two angles in rad, or let-go");
  }
  return target;
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
      if (const auto target = parse_hand(std::string_view(pending_).substr(0, end))) {
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
