#pragma once
/// How a request is refused: a stable reason for programs, a sentence for people.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace haptic::server {

/// A refusal with a stable reason ("LEASE_HELD", "NOT_ARMED", ...) and a sentence for people.
struct Refusal {
  enum class Code : std::uint8_t {
    kInvalid,       ///< a field is off, whatever the state; `field` names it
    kNotFound,      ///< no such device or session
    kExists,        ///< somebody else has it
    kPrecondition,  ///< not now; the message names the value that is not good enough yet
    kPermission,    ///< not this session's to ask
    kExhausted,     ///< a limit of the server is reached
    kAborted,       ///< another call took this one's place
    kUnavailable,   ///< the server is closing, or its loop gave no answer in time
  };
  Code code{Code::kInvalid};
  std::string reason{};
  std::string message{};
  std::string field{};  ///< kInvalid: the field that is off
  /// What a program may want to know besides, by name: {"holder", "alice"}.
  std::vector<std::pair<std::string, std::string>> details{};
};

/// A value, or why there is none.
template <typename T>
struct Outcome {
  std::optional<T> value{};
  Refusal refusal{};

  Outcome(T granted) : value(std::move(granted)) {}          // NOLINT(google-explicit-constructor)
  Outcome(Refusal refused) : refusal(std::move(refused)) {}  // NOLINT(google-explicit-constructor)
  explicit operator bool() const noexcept { return value.has_value(); }
};

/// The answer to a request that yields nothing but yes.
struct Done {};

}  // namespace haptic::server
