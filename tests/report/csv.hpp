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

/// The cells with commas between, without the line's end.
template <typename First, typename... Rest>
[[nodiscard]] std::string line_of(const First& first, const Rest&... rest) {
  std::string line = cell(first);
  ((line += ',', line += cell(rest)), ...);
  return line;
}

template <typename... Cells>
void row(const Cells&... cells) {
  std::puts(line_of(cells...).c_str());
}

}  // namespace haptic::report
