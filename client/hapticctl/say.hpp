#pragma once
/// The output of hapticctl. A server may be anyone, and its text any bytes: every std::string goes
/// through wire::printable() here, so that none moves the terminal's cursor or pretends to be a
/// line of its own. JSON is ASCII.

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "haptic/wire/printable.hpp"

namespace haptic::ctl {

/// An argument of printf.
template <typename T>
struct Shown {
  explicit Shown(const T& its_value) : value(its_value) {}
  [[nodiscard]] const T& get() const { return value; }
  const T& value;
};
template <>
struct Shown<std::string> {
  explicit Shown(const std::string& text) : value(wire::printable(text)) {}
  [[nodiscard]] const char* get() const { return value.c_str(); }
  const std::string value;
};

/// Formatted as printf does: %s takes a std::string, made printable, or words of this program.
template <typename... Arguments>
[[nodiscard]] std::string text(const char* format, const Arguments&... arguments) {
  std::string all;
  const int size = std::snprintf(nullptr, 0, format, Shown(arguments).get()...);
  all.resize(static_cast<std::size_t>(size > 0 ? size : 0) + 1);
  std::snprintf(all.data(), all.size(), format, Shown(arguments).get()...);
  all.pop_back();
  return all;
}

/// To standard output.
template <typename... Arguments>
void say(const char* format, const Arguments&... arguments) {
  std::fputs(text(format, arguments...).c_str(), stdout);
}

/// To standard error, a line that begins with the program's name.
template <typename... Arguments>
void complain(const char* format, const Arguments&... arguments) {
  std::fprintf(stderr, "hapticctl: %s\n", text(format, arguments...).c_str());
}

/// In ASCII; what is no UTF-8 becomes U+FFFD.
[[nodiscard]] inline std::string dump(const nlohmann::json& value, int indent = -1) {
  return value.dump(indent, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace haptic::ctl
