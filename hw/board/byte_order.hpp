#pragma once
/// Little-endian numbers in a buffer, whatever the host's own order. Floats are IEEE 754 binary32.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace haptic::hw::board {

/// Writes into a buffer that the caller knows to be long enough; beyond its end nothing is written.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::uint8_t> buffer) noexcept : buffer_(buffer) {}
  void u8(std::uint8_t value) noexcept {
    if (length_ < buffer_.size()) buffer_[length_++] = value;
  }
  void u16(std::uint16_t value) noexcept { little_endian(value, 2); }
  void u32(std::uint32_t value) noexcept { little_endian(value, 4); }
  void u64(std::uint64_t value) noexcept { little_endian(value, 8); }
  void f32(float value) noexcept { u32(std::bit_cast<std::uint32_t>(value)); }
  void bytes(std::span<const std::uint8_t> values) noexcept {
    for (const std::uint8_t value : values) u8(value);
  }
  /// Text padded with zeros to `width` bytes; what is longer is cut.
  void text(std::string_view value, std::size_t width) noexcept {
    for (std::size_t i = 0; i < width; ++i) {
      u8(i < value.size() ? static_cast<std::uint8_t>(value[i]) : std::uint8_t{0});
    }
  }
  [[nodiscard]] std::span<const std::uint8_t> written() const noexcept {
    return buffer_.first(length_);
  }

 private:
  void little_endian(std::uint64_t value, int count) noexcept {
    for (int i = 0; i < count; ++i) u8(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  std::span<std::uint8_t> buffer_;
  std::size_t length_{0};
};

/// Reads from a buffer that the caller knows to be long enough; beyond its end it reads zeros.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> buffer) noexcept : buffer_(buffer) {}
  [[nodiscard]] std::uint8_t u8() noexcept { return at_ < buffer_.size() ? buffer_[at_++] : 0; }
  [[nodiscard]] std::uint16_t u16() noexcept {
    return static_cast<std::uint16_t>(little_endian(2));
  }
  [[nodiscard]] std::uint32_t u32() noexcept {
    return static_cast<std::uint32_t>(little_endian(4));
  }
  [[nodiscard]] std::uint64_t u64() noexcept { return little_endian(8); }
  [[nodiscard]] float f32() noexcept { return std::bit_cast<float>(u32()); }
  /// Up to the first zero of `width` bytes.
  [[nodiscard]] std::string text(std::size_t width) {
    const auto field = rest().first(std::min(width, rest().size()));
    at_ += field.size();
    const auto end = std::find(field.begin(), field.end(), std::uint8_t{0});
    return {field.begin(), end};
  }
  [[nodiscard]] std::span<const std::uint8_t> rest() const noexcept { return buffer_.subspan(at_); }

 private:
  [[nodiscard]] std::uint64_t little_endian(int count) noexcept {
    std::uint64_t value = 0;
    for (int i = 0; i < count; ++i) value |= static_cast<std::uint64_t>(u8()) << (8 * i);
    return value;
  }
  std::span<const std::uint8_t> buffer_;
  std::size_t at_{0};
};

}  // namespace haptic::hw::board
