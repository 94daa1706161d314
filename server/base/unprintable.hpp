#pragma once
/// Characters that change how a line looks, in text of a client or a device.

#include <string_view>

namespace haptic::server {

/// Bytes of the character of UTF-8 at `at` if a terminal would not show it as itself, else 0: a
/// control character (C0, DEL, C1: U+0080..U+009F) or one that turns the writing direction of what
/// follows (U+061C, U+200E, U+200F, U+202A..U+202E, U+2066..U+2069).
[[nodiscard]] constexpr std::size_t unprintable(std::string_view text, std::size_t at) noexcept {
  const auto byte = [&](std::size_t i) -> unsigned {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0U;
  };
  const auto within = [](unsigned value, unsigned low, unsigned high) {
    return value >= low && value <= high;
  };
  if (byte(0) < 0x20 || byte(0) == 0x7F) return 1;
  if (byte(0) == 0xC2 && within(byte(1), 0x80, 0x9F)) return 2;
  if (byte(0) == 0xD8 && byte(1) == 0x9C) return 2;
  const bool marks =
      byte(1) == 0x80 && (within(byte(2), 0x8E, 0x8F) || within(byte(2), 0xAA, 0xAE));
  const bool isolates = byte(1) == 0x81 && within(byte(2), 0xA6, 0xA9);
  return byte(0) == 0xE2 && (marks || isolates) ? 3 : 0;
}

}  // namespace haptic::server
