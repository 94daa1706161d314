#pragma once
/// Rows of CSV on standard output. Numbers carry ten significant digits, NaN is written "nan".

#include <cmath>
#include <concepts>
#include <cstdio>
#include <string>
#include <string_view>

#include "tests/support/csv.hpp"

namespace haptic::report {

[[nodiscard]] inline std::string cell(double value) {
  if (std::isnan(value)) return "nan";
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}
[[nodiscard]] inline std::string cell(std::string_view text) {
  return test::csv_field(text);
}
[[nodiscard]] inline std::string cell(const char* text) {
  return test::csv_field(text);
}
/// Cells that are one already.
struct Line {
  std::string text{};
};
[[nodiscard]] inline const std::string& cell(const Line& line) {
  return line.text;
}
template <std::integral Whole>
[[nodiscard]] std::string cell(Whole value) {
  return std::to_string(value);
}

/// The cells with commas between, without the line's end.
template <typename First, typename... Rest>
[[nodiscard]] Line line_of(const First& first, const Rest&... rest) {
  Line line{cell(first)};
  ((line.text += ',', line.text += cell(rest)), ...);
  return line;
}

template <typename... Cells>
void row(const Cells&... cells) {
  std::puts(line_of(cells...).text.c_str());
}

}  // namespace haptic::report
