#pragma once
/// A scene's text into its message, with positions.

#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Deepest nesting of messages that is read; a scene needs four.
inline constexpr int kDeepestNesting = 16;

/// Reads `text` into `message`, and into `tree` where each field stands. Text
/// that is no textproto throws SceneError at its first error,
/// "name:line:column: what". Unknown fields go to `problems`, all of them, each
/// with its line, column and the fields there are.
void parse_text(const std::string& text, const std::string& name, v1::Scene& message,
                Problems::Tree& tree, Problems& problems);

/// Reads `text` as one message of --set. Empty where it went well; else what is
/// wrong, for people.
[[nodiscard]] std::string parse_fragment(const std::string& text,
                                         google::protobuf::Message& message);

}  // namespace haptic::server
