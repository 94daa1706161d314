#include "tests/report/values.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace haptic::report {

bool lexical_cast(const std::string& text, Pair& pair) {
  char* end = nullptr;
  const double first = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != ',') return false;
  const char* rest = end + 1;
  const double second = std::strtod(rest, &end);
  if (end == rest || *end != '\0' || !std::isfinite(first) || !std::isfinite(second)) return false;
  pair = {first, second};
  return true;
}

std::string to_string(const Pair& pair) {
  char text[64];
  std::snprintf(text, sizeof text, "%g,%g", pair.first, pair.second);
  return text;
}

}  // namespace haptic::report
