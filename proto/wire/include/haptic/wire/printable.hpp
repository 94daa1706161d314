#pragma once
/// Text from outside as one line that is safe on a terminal: of a client or a device in the
/// server's log, of a server in hapticctl.

#include <string>
#include <string_view>

namespace haptic::wire {

struct Character {
  std::size_t bytes{1};
  bool shows_itself{false};  ///< on a terminal
};

/// The character of UTF-8 that begins at `at`, which is below the text's size. Not shown as itself
/// are: a control character (C0, DEL, C1: U+0080..U+009F), one that breaks the line (U+2028,
/// U+2029) or turns the writing direction of what follows (U+061C, U+200E, U+200F, U+202A..U+202E,
/// U+2066..U+2069), and each byte of what is no UTF-8: a terminal may take 0x9B as a command.
[[nodiscard]] constexpr Character character(std::string_view text, std::size_t at) noexcept {
  const auto byte = [&](std::size_t i) -> unsigned {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0U;
  };
  const auto within = [](unsigned value, unsigned low, unsigned high) {
    return value >= low && value <= high;
  };
  if (byte(0) < 0x80) return {1, byte(0) >= 0x20 && byte(0) != 0x7F};
  const std::size_t size = within(byte(0), 0xC2, 0xDF)   ? 2
                           : within(byte(0), 0xE0, 0xEF) ? 3
                           : within(byte(0), 0xF0, 0xF4) ? 4
                                                         : 1;
  for (std::size_t i = 1; i < size; ++i) {
    if (!within(byte(i), 0x80, 0xBF)) return {1, false};
  }
  // A form that is longer than need be, a surrogate, a number that is too large.
  const bool odd = (byte(0) == 0xE0 && byte(1) < 0xA0) || (byte(0) == 0xED && byte(1) > 0x9F) ||
                   (byte(0) == 0xF0 && byte(1) < 0x90) || (byte(0) == 0xF4 && byte(1) > 0x8F);
  if (odd) return {1, false};
  if (size == 1 || (byte(0) == 0xC2 && byte(1) < 0xA0)) return {size, false};
  const bool letter_mark = byte(0) == 0xD8 && byte(1) == 0x9C;
  const bool marks =
      byte(1) == 0x80 && (within(byte(2), 0x8E, 0x8F) || within(byte(2), 0xA8, 0xAE));
  const bool isolates = byte(1) == 0x81 && within(byte(2), 0xA6, 0xA9);
  return {size, !letter_mark && !(byte(0) == 0xE2 && (marks || isolates))};
}

/// "\x0a" for each byte that does not show itself; everything else, a backslash too, stays readable
/// as it is. Done twice it is the same.
[[nodiscard]] inline std::string printable(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string line;
  line.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const Character next = character(text, i);
    if (next.shows_itself) line.append(text, i, next.bytes);
    for (std::size_t k = i; !next.shows_itself && k < i + next.bytes; ++k) {
      const auto byte = static_cast<unsigned char>(text[k]);
      line.append("\\x") += kDigits[byte / 16U];
      line += kDigits[byte % 16U];
    }
    i += next.bytes;
  }
  return line;
}

}  // namespace haptic::wire
