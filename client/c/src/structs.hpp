#pragma once
/// How the structs and the text of haptic_types.h cross the border: sizes are believed only within
/// bounds, text is cut at a whole character.

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "haptic/client/error.hpp"
#include "haptic/haptic_types.h"

namespace haptic::c {

[[noreturn]] inline void refuse(const std::string& message) {
  throw client::ClientError(client::ErrorReason::kInvalidArgument, message);
}

template <typename T>
T* given(T* pointer, const char* name) {
  if (pointer == nullptr) refuse(std::string(name) + " is NULL, must point at memory of yours");
  return pointer;
}

/// sizeof(T) in the first release, which is the least that a caller may have: a struct that grows
/// gets its former size here.
template <typename T>
inline constexpr std::size_t kFirstSize = sizeof(T);
/// A state grows with the protocol: a caller may know any first part of it that has the tick.
template <>
inline constexpr std::size_t kFirstSize<haptic_state> = offsetof(haptic_state, server_time_ns);
/// No later release will have made a struct four times as large, but memory without a value may say
/// so.
template <typename T>
inline constexpr std::size_t kLargestSize = 4 * sizeof(T);

template <typename T>
T* sized(T* pointer, const char* name) {
  const std::size_t size = given(pointer, name)->size;
  if (size < kFirstSize<T> || size > kLargestSize<T>) {
    refuse(std::string(name) + "->size = " + std::to_string(size) + ", must be sizeof *" + name +
           " (" + std::to_string(sizeof(T)) + ")");
  }
  return pointer;
}

/// The struct that the caller wrote, and 0 for what its release does not know.
template <typename T>
T read(const T* from, const char* name) {
  const std::size_t size = sized(from, name)->size;
  T value{};
  std::memcpy(&value, from, std::min(size, sizeof value));
  const char* const bytes = reinterpret_cast<const char*>(from);
  for (std::size_t i = sizeof value; i < size; ++i) {
    if (bytes[i] != 0) {
      refuse(std::string(name) + " has a field that this release (" HAPTIC_VERSION
                                 ") does not know, must be 0");
    }
  }
  return value;
}

/// `to` was checked by sized().
template <typename T>
void write(const T& value, T* to) {
  const std::size_t size = to->size;
  std::memset(to, 0, size);
  std::memcpy(to, &value, std::min(size, sizeof value));
  to->size = size;
}

/// The first `capacity` of `values`, each of the size to[0].size, which sized() has checked.
template <typename T, typename Value, typename Convert>
void write_each(const std::vector<Value>& values, T* to, std::size_t capacity, Convert convert) {
  const std::size_t count = std::min(capacity, values.size()), size = count > 0 ? to->size : 0;
  for (std::size_t i = 0; i < count; ++i) {
    auto* const each = reinterpret_cast<T*>(reinterpret_cast<char*>(to) + i * size);
    each->size = size;
    write(convert(values[i]), each);
  }
}

template <std::size_t kSize>
void write_text(std::string_view text, char (&to)[kSize]) noexcept {
  std::size_t length = std::min(text.size(), kSize - 1);
  const auto continues = [&](std::size_t i) {
    return i < text.size() && (static_cast<unsigned char>(text[i]) & 0xC0U) == 0x80U;
  };
  while (length > 0 && continues(length)) --length;
  std::memset(to, 0, kSize);
  std::memcpy(to, text.data(), length);
}

/// A line each.
inline std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : "\n") + text;
  return all;
}

/// How many of `values` have room.
template <typename Value, typename Struct, std::size_t kMost>
std::uint32_t fitting(const std::vector<Value>& values, const Struct (&)[kMost]) noexcept {
  return static_cast<std::uint32_t>(std::min(values.size(), kMost));
}

/// Opening a session made sure that no list is longer.
template <typename Value, typename List>
void write_list(const std::vector<Value>& values, List& to) {
  constexpr std::size_t kMost = std::size(decltype(to.value){});
  to.count = static_cast<std::uint32_t>(std::min(values.size(), kMost));
  std::copy_n(values.begin(), to.count, to.value);
}

inline std::vector<double> read_list(const haptic_dofs& from, const char* name) {
  if (from.count > HAPTIC_MAX_DOFS) {
    refuse(std::string(name) + ".count = " + std::to_string(from.count) + ", must be at most " +
           std::to_string(HAPTIC_MAX_DOFS));
  }
  return {from.value, from.value + from.count};
}

inline std::string text_or(const char* text, const char* otherwise) {
  return text == nullptr ? otherwise : text;
}

}  // namespace haptic::c
