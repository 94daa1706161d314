#pragma once
/// The commands of the local control socket, as text.
///
///   stop [DEVICE] [newline REASON]    every local user          "ok", a line per device
///   clear [DEVICE] [newline FAULTS]   hapticd's user and root   "ok", the bits that were cleared
///   health                            every local user          "ok" and local_health.hpp's lines
///   restart-front                     hapticd's user and root   "ok" when the new one serves
///
/// No device: all of them, or for clear the only one. FAULTS: bits, as a decimal number; none: all.
/// Anything else is answered with "refused: " and why.

#include <cstdint>
#include <string>
#include <string_view>

namespace haptic::server {

struct ControlCommand {
  static constexpr std::size_t kLongest = 384;  ///< bytes

  enum class Kind : std::uint8_t { kStop, kClear, kHealth, kRestartFront };
  Kind kind{Kind::kStop};
  std::string device{};       ///< empty: all
  std::string reason{};       ///< kStop
  std::uint32_t faults{0};    ///< kClear; 0: all
  std::uint64_t reply_to{0};  ///< for ControlSocket::answer()
  unsigned user{0};
  bool trusted{false};  ///< `user` is root, or the one that runs hapticd
};

/// The text as a command; a sentence for people if it is none.
struct ParsedCommand {
  ControlCommand command{};
  std::string wrong{};  ///< empty: `command` is set
};
[[nodiscard]] ParsedCommand parse_command(std::string_view text);

}  // namespace haptic::server
