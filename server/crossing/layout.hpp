#pragma once
/// Layout of a struct as a number, made of the names, types and offsets of everything that it
/// holds: two programs compare it before they share memory. And a check that a struct may be
/// written by anybody.

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "haptic/core/fault.hpp"
#include "server/crossing/fields.hpp"
#include "server/crossing/plain.hpp"
#include "server/crossing/text.hpp"

namespace haptic::server {

/// The type of the values in a class with private members; void: its name says all of it.
template <typename T>
struct Held {
  using Type = void;
};
template <typename T>
struct Held<Maybe<T>> {
  using Type = T;
};
template <typename T>
struct Held<std::optional<T>> {
  using Type = T;
};
template <typename T>
struct Held<std::atomic<T>> {
  using Type = T;
};
template <typename T, std::size_t N>
struct Held<std::array<T, N>> {
  using Type = T;
};
template <typename T>
struct Held<std::vector<T>> {
  using Type = T;
};

/// FNV-1a.
class LayoutHash {
 public:
  constexpr void add(std::uint64_t part) noexcept { hash_ = (hash_ ^ part) * 1099511628211ULL; }
  constexpr void add(std::string_view text) noexcept {
    for (const char c : text) add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
  }
  [[nodiscard]] constexpr std::uint64_t value() const noexcept { return hash_; }

 private:
  std::uint64_t hash_{14695981039346656037ULL};
};

template <typename T>
constexpr std::uint64_t layout() noexcept;

/// A struct's part of the number, without its own name: another one if a field was added, moved,
/// renamed or given another type.
template <typename T>
constexpr std::uint64_t layout_of_fields() noexcept {
  static_assert(std::is_standard_layout_v<T>);
  using Types = decltype(fields_of(std::declval<T&>()));
  LayoutHash hash;
  std::size_t offset = 0;
  const auto add = [&]<std::size_t index>() {
    using Field = std::remove_cvref_t<std::tuple_element_t<index, Types>>;
    offset = (offset + alignof(Field) - 1) / alignof(Field) * alignof(Field);
    hash.add(field_name<T, index>());
    hash.add(offset);
    hash.add(layout<Field>());
    offset += sizeof(Field);
  };
  [&]<std::size_t... index>(std::index_sequence<index...>) {
    (add.template operator()<index>(), ...);
  }
  (std::make_index_sequence<std::tuple_size_v<Types>>());
  return hash.value();
}

/// An enumeration's part of the number: another one if a value up to 31 was added, moved or given
/// another name.
template <typename T>
constexpr std::uint64_t layout_of_values() noexcept {
  LayoutHash hash;
  [&]<std::size_t... value>(std::index_sequence<value...>) {
    (hash.add(value_name<static_cast<T>(value)>()), ...);
  }
  (std::make_index_sequence<32>());
  return hash.value();
}

/// A type's part of the number.
template <typename T>
constexpr std::uint64_t layout() noexcept {
  LayoutHash hash;
  hash.add(type_name<T>());
  hash.add(sizeof(T));
  using Inside = typename Held<T>::Type;
  if constexpr (!std::is_void_v<Inside>) {
    hash.add(layout<Inside>());
  } else if constexpr (std::is_class_v<T> && std::is_aggregate_v<T>) {
    hash.add(layout_of_fields<T>());
  } else if constexpr (std::is_enum_v<T>) {
    hash.add(layout_of_values<T>());
  }
  return hash.value();
}

/// Every pattern of bits is a value of the class.
template <typename T>
inline constexpr bool kAnyBits = false;
template <>
inline constexpr bool kAnyBits<Flag> = true;
template <>
inline constexpr bool kAnyBits<core::FaultSet> = true;
template <std::size_t N>
inline constexpr bool kAnyBits<Text<N>> = true;
template <typename Rep, typename Period>
inline constexpr bool kAnyBits<std::chrono::duration<Rep, Period>> = true;
template <typename Clock, typename Duration>
inline constexpr bool kAnyBits<std::chrono::time_point<Clock, Duration>> = true;

/// Every pattern of bits is a value of T, so that a broken front can do no harm by what it writes.
template <typename T>
constexpr bool any_bits() noexcept {
  using Inside = typename Held<T>::Type;
  if constexpr (std::is_same_v<T, bool> || !std::is_trivially_copyable_v<T>) {
    return false;
  } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T> || kAnyBits<T>) {
    return true;
  } else if constexpr (std::is_same_v<T, Maybe<Inside>> || requires { T{}.front(); }) {
    return any_bits<Inside>();
  } else if constexpr (std::is_class_v<T> && std::is_aggregate_v<T>) {
    using Types = decltype(fields_of(std::declval<T&>()));
    return []<std::size_t... index>(std::index_sequence<index...>) {
      return (any_bits<std::remove_cvref_t<std::tuple_element_t<index, Types>>>() && ...);
    }
    (std::make_index_sequence<std::tuple_size_v<Types>>());
  }
  return false;
}

}  // namespace haptic::server
