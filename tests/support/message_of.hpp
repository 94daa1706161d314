#pragma once
/// The words of an error that a call must throw.

#include <string>

namespace haptic::test {

/// Returns the message of the `Error` that `action` throws, or "no error" if it throws nothing.
template <typename Error, typename Action>
[[nodiscard]] std::string message_of(Action action) {
  try {
    static_cast<void>(action());
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace haptic::test
