#include "server/owner/local/control_command.hpp"

#include <array>
#include <charconv>

namespace haptic::server {

ParsedCommand parse_command(std::string_view text) {
  using Kind = ControlCommand::Kind;
  while (!text.empty() && (text.back() == '\n' || text.back() == '\0')) text.remove_suffix(1);
  const std::size_t line = text.find('\n');
  if (text.size() > ControlCommand::kLongest) {
    // A stop is not refused for its reason.
    if (!text.starts_with("stop") || line >= ControlCommand::kLongest) {
      return {{}, "refused: too long"};
    }
    text = text.substr(0, ControlCommand::kLongest);
  }
  const std::string_view rest = line == std::string_view::npos ? "" : text.substr(line + 1);
  text = text.substr(0, line);
  const std::size_t blank = text.find(' ');
  const std::string_view word = text.substr(0, blank);
  ControlCommand command;
  if (blank != std::string_view::npos) command.device = text.substr(blank + 1);
  struct Word {
    std::string_view text;
    Kind kind;
    bool of_device;
  };
  static constexpr std::array kWords{
      Word{"stop", Kind::kStop, true}, Word{"clear", Kind::kClear, true},
      Word{"health", Kind::kHealth, false}, Word{"restart-front", Kind::kRestartFront, false}};
  for (const Word& known : kWords) {
    if (word != known.text) continue;
    if (!(command.device.empty() && rest.empty()) && !known.of_device) break;
    command.kind = known.kind;
    command.reason = rest;
    if (known.kind == Kind::kClear && !rest.empty()) {
      const auto end = rest.data() + rest.size();
      const auto read = std::from_chars(rest.data(), end, command.faults);
      if (read.ptr != end || read.ec != std::errc()) {
        return {{}, "refused: the faults must be a number, their bits"};
      }
    }
    return {command, {}};
  }
  return {{}, "refused: must be stop [DEVICE], clear [DEVICE], health or restart-front"};
}

}  // namespace haptic::server
