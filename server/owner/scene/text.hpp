#pragma once
/// The text of a scene: parsing with positions, --set, and suggestions for misspelt names.

#include <string>

#include "haptic/v1/scene.pb.h"
#include "server/owner/scene/problems.hpp"

namespace haptic::server {

/// Bytes of a scene's text; all that ship together have a tenth of it.
inline constexpr std::size_t kLargestScene = 1 << 18;
/// Deepest nesting of messages that is read; a scene needs four.
inline constexpr int kDeepestNesting = 16;

/// Reads `text` into `message`, and the places of its fields into `tree`. Unknown fields go to
/// `problems`, each with its line, column and the fields there are. Throws SceneError
/// at the first syntax error, "name:line:column: what".
void parse_text(const std::string& text, const std::string& name, v1::Scene& message,
                Problems::Tree& tree, Problems& problems);

/// Reads `text` as one message. Empty if it went well; else what is wrong.
[[nodiscard]] std::string parse_fragment(const std::string& text,
                                         google::protobuf::Message& message);

/// Applies "path=value" of --set, which sets one field of the scene; creates the messages on the
/// way; returns the path. Throws SceneError and leaves `scene` unchanged: no path=value, a step
/// that does not exist (with those that do), a value that the field does not take.
///
///     device[0].impedance.stiffness_n_per_m[0]=800    one entry of a list
///     device[0].impedance.stiffness_n_per_m=[800]     the whole list
///     server.listen[1]=unix:/run/hapticd.sock         index = size appends; quotes are optional
///     device[0].direction_guard={}                    presence selects
///     device[0].standard={}                           replaces the other member of a oneof
FieldPath apply_override(const std::string& assignment, v1::Scene& scene);

/// The fields of a message type as "a, b, c", first those that begin most like `wanted`; "no
/// fields" if the type has none.
[[nodiscard]] std::string fields_of(const google::protobuf::Descriptor& type,
                                    const std::string& wanted);

}  // namespace haptic::server
