#pragma once
/// Text that may travel: a `string` field that is not UTF-8 makes the whole message unreadable to
/// protobuf, an emergency stop included.

#include <string_view>

namespace haptic::wire {

/// Well-formed by RFC 3629: shortest forms only, no surrogates, nothing above U+10FFFF.
[[nodiscard]] constexpr bool is_utf8(std::string_view text) noexcept {
  for (std::size_t at = 0; at < text.size();) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned lead = byte(at++);
    if (lead < 0x80) continue;
    const std::size_t more = lead >= 0xF0 ? 3 : lead >= 0xE0 ? 2 : 1;
    if (lead < 0xC2 || lead > 0xF4 || text.size() - at < more) return false;
    // The first continuation byte tells a longer form, a surrogate or a number that is too large.
    unsigned lowest = 0x80;
    unsigned highest = 0xBF;
    if (lead == 0xE0) lowest = 0xA0;
    if (lead == 0xED) highest = 0x9F;
    if (lead == 0xF0) lowest = 0x90;
    if (lead == 0xF4) highest = 0x8F;
    if (byte(at) < lowest || byte(at) > highest) return false;
    for (std::size_t i = 1; i < more; ++i) {
      if ((byte(at + i) & 0xC0U) != 0x80U) return false;
    }
    at += more;
  }
  return true;
}

}  // namespace haptic::wire
