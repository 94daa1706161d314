#pragma once
/// A string of bounded length, stored in place, so that it can lie in memory that two processes
/// share.

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <ostream>
#include <string>
#include <string_view>

namespace haptic::server {

/// At most N bytes of UTF-8. A longer text is cut at a character's border. Another process may have
/// written it: whatever its bits are, view() stays within it.
template <std::size_t N>
class Text {
 public:
  Text() = default;
  template <std::convertible_to<std::string_view> T>
  Text(const T& text) {  // NOLINT(google-explicit-constructor): it stands for a string
    const std::string_view from = text;
    std::size_t size = std::min(from.size(), N);
    while (size < from.size() && size > 0 &&
           (static_cast<unsigned char>(from[size]) & 0xC0U) == 0x80U) {
      --size;
    }
    std::copy_n(from.data(), size, chars_.data());
    size_ = static_cast<std::uint32_t>(size);
  }

  [[nodiscard]] std::string_view view() const noexcept {
    return {chars_.data(), std::min<std::size_t>(size_, N)};
  }
  operator std::string_view() const noexcept {
    return view();
  }  // NOLINT(google-explicit-constructor)
  [[nodiscard]] std::string str() const { return std::string(view()); }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }

  template <std::convertible_to<std::string_view> T>
  friend bool operator==(const Text& a, const T& b) noexcept {
    return a.view() == std::string_view(b);
  }
  friend std::ostream& operator<<(std::ostream& out, const Text& text) {
    return out << text.view();
  }

 private:
  std::uint32_t size_{0};
  std::array<char, N> chars_{};
};

}  // namespace haptic::server
