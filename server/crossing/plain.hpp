#pragma once
/// A truth value and an optional value that may come from another process: every bit pattern
/// is a valid value, which does not hold for bool and std::optional.

#include <concepts>
#include <cstdint>
#include <optional>
#include <type_traits>

namespace haptic::server {

class Flag {
 public:
  constexpr Flag(bool value = false) noexcept  // NOLINT(google-explicit-constructor): it is a bool
      : value_(value ? 1 : 0) {}
  constexpr operator bool() const noexcept {  // NOLINT(google-explicit-constructor)
    return value_ != 0;
  }

 private:
  std::uint8_t value_;
};

template <typename T>
class Maybe {
  static_assert(std::is_trivially_copyable_v<T> && !std::is_same_v<T, bool>);

 public:
  constexpr Maybe() noexcept = default;
  constexpr Maybe(std::nullopt_t) noexcept {}  // NOLINT(google-explicit-constructor)
  template <std::convertible_to<T> From>
  constexpr Maybe(const From& value) noexcept  // NOLINT(google-explicit-constructor)
      : present_(true), value_(value) {}
  constexpr Maybe(const std::optional<T>& value) noexcept  // NOLINT(google-explicit-constructor)
      : present_(value.has_value()), value_(value.value_or(T{})) {}

  [[nodiscard]] constexpr bool has_value() const noexcept { return present_; }
  constexpr explicit operator bool() const noexcept { return present_; }
  [[nodiscard]] constexpr const T& operator*() const noexcept { return value_; }
  [[nodiscard]] constexpr T value_or(const T& other) const noexcept {
    return present_ ? value_ : other;
  }

 private:
  Flag present_{};
  T value_{};
};

}  // namespace haptic::server
