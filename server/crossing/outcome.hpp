#pragma once
/// A value, or why there is none.

#include <optional>
#include <string>
#include <utility>

#include "server/crossing/crossing.hpp"

namespace haptic::server {

template <typename T>
struct Outcome {
  std::optional<T> value{};
  Refusal refusal{};

  Outcome(T granted) : value(std::move(granted)) {}      // NOLINT(google-explicit-constructor)
  Outcome(const Refusal& refused) : refusal(refused) {}  // NOLINT(google-explicit-constructor)
  explicit operator bool() const noexcept { return value.has_value(); }
};

/// kInvalid, of one field: "name = value: what is allowed".
[[nodiscard]] inline Refusal invalid_field(const std::string& field, const std::string& rest) {
  return {Refusal::Code::kInvalid, "INVALID_ARGUMENT", field + " " + rest, field};
}

/// kExhausted: `limit` of the server is reached.
[[nodiscard]] inline Refusal limit_reached(const char* reason, const std::string& message,
                                           std::size_t limit) {
  return {Refusal::Code::kExhausted, reason, message, {}, {{{"limit", std::to_string(limit)}}}};
}

}  // namespace haptic::server
