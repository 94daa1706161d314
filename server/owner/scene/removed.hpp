#pragma once
/// Fields that a scene could have in an earlier version. protobuf skips a reserved name without a
/// word, and a scene that still has one must not be served with less than it asks for.

#include <string>

namespace haptic::server {

/// The advice about the field: "`NAME` was removed in VERSION: delete the line; ...". Empty: no
/// field of this name was removed.
[[nodiscard]] std::string removed_field(const std::string& name);

}  // namespace haptic::server
