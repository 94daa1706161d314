#pragma once
/// The verdict on a sample that is not used, with its words: field, value and what is allowed.

#include <spdlog/fmt/fmt.h>

#include <array>
#include <string_view>

#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// Allocates nothing, because the loop's thread judges samples as well (SampleIntake).
template <typename... Values>
[[nodiscard]] Verdict refused(IngressVerdict verdict, fmt::format_string<const Values&...> words,
                              const Values&... values) {
  std::array<char, 256> text;
  const auto end = fmt::format_to_n(text.data(), text.size(), words, values...).out;
  return {verdict, std::string_view(text.data(), static_cast<std::size_t>(end - text.data()))};
}

}  // namespace haptic::server
