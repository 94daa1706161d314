#pragma once
/// Little-endian numbers in a buffer, in any byte order of the host. Floats are IEEE 754 binary32.
///
/// Writer and reader have the same three operations, so that one function which lists the fields
/// of a message serves both:
///
///   io(a, b, ...)      numbers, enumerators and bools, each in its own width
///   io.text(t, width)  text, padded with zeros
///   io.list(v, count)  the first `count` numbers of an array

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>

namespace haptic::hw::board {

/// Writes into a buffer that the caller knows to be long enough; beyond its end nothing is written.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::uint8_t> buffer) noexcept : buffer_(buffer) {}

  template <typename... Numbers>
  void operator()(Numbers... values) noexcept {
    (put(values), ...);
  }
  /// Text longer than `width` is cut.
  void text(const std::string& value, std::size_t width) noexcept {
    for (std::size_t i = 0; i < width; ++i) put(i < value.size() ? value[i] : '\0');
  }
  template <typename Number, std::size_t kSize>
  void list(const std::array<Number, kSize>& values, std::size_t count) noexcept {
    for (std::size_t i = 0; i < std::min(count, kSize); ++i) put(values[i]);
  }
  [[nodiscard]] std::span<const std::uint8_t> written() const noexcept {
    return buffer_.first(length_);
  }

 private:
  template <typename Number>
  void put(Number value) noexcept {
    if constexpr (std::is_same_v<Number, float>) {
      put(std::bit_cast<std::uint32_t>(value));
    } else {
      const auto bits = static_cast<std::uint64_t>(value);
      for (std::size_t i = 0; i < sizeof value && length_ < buffer_.size(); ++i) {
        buffer_[length_++] = static_cast<std::uint8_t>(bits >> (8 * i));
      }
    }
  }

  std::span<std::uint8_t> buffer_;
  std::size_t length_{0};
};

/// Reads what a ByteWriter wrote. Beyond the end of the buffer it reads zeros and is not exact().
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> buffer) noexcept : rest_(buffer) {}

  template <typename... Numbers>
  void operator()(Numbers&... values) noexcept {
    (take(values), ...);
  }
  /// Up to the first zero of `width` bytes. What is not printable ASCII becomes '?': here text of a
  /// board enters, and from here it goes into answers, which must be UTF-8, and onto terminals.
  void text(std::string& value, std::size_t width) {
    value.resize(width);
    for (char& character : value) take(character);
    value.resize(std::min(value.find('\0'), width));
    std::replace_if(
        value.begin(), value.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  }
  template <typename Number, std::size_t kSize>
  void list(std::array<Number, kSize>& values, std::size_t count) noexcept {
    for (std::size_t i = 0; i < std::min(count, kSize); ++i) take(values[i]);
  }
  /// All bytes were read and no more, and every bool was 0 or 1.
  [[nodiscard]] bool exact() const noexcept { return good_ && rest_.empty(); }

 private:
  template <typename Number>
  void take(Number& value) noexcept {
    if constexpr (std::is_same_v<Number, float>) {
      std::uint32_t bits = 0;
      take(bits);
      value = std::bit_cast<float>(bits);
    } else {
      std::uint64_t bits = 0;
      const std::size_t length = std::min(sizeof value, rest_.size());
      for (std::size_t i = 0; i < length; ++i) bits |= std::uint64_t{rest_[i]} << (8 * i);
      rest_ = rest_.subspan(length);
      good_ = good_ && length == sizeof value && (!std::is_same_v<Number, bool> || bits <= 1);
      value = static_cast<Number>(bits);
    }
  }

  std::span<const std::uint8_t> rest_;
  bool good_{true};
};

}  // namespace haptic::hw::board
