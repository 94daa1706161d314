#pragma once
/// Rows of CSV on standard output. Numbers carry ten significant digits, NaN is written "nan".

#include <concepts>
#include <cstdio>
#include <string>
#include <string_view>

namespace haptic::report {

[[nodiscard]] std::string cell(double value);
/// Quoted where it holds a comma, a quote or a line break.
[[nodiscard]] std::string cell(std::string_view text);
[[nodiscard]] inline std::string cell(const char* text) {
  return cell(std::string_view(text));
}
template <std::integral Whole>
[[nodiscard]] std::string cell(Whole value) {
  return std::to_string(value);
}

template <typename First, typename... Rest>
void row(const First& first, const Rest&... rest) {
  std::string line = cell(first);
  ((line += ',', line += cell(rest)), ...);
  line += '\n';
  std::fputs(line.c_str(), stdout);
}

}  // namespace haptic::report
