#pragma once
/// Names of DoFs, coordinates, joints, fingers: columns of recordings and heads of tables.

#include <set>
#include <string>

#include "server/scene/field_reader.hpp"

namespace haptic::server {

/// Reports unless the message's name is 1 to `longest` letters, digits, _ and -,
/// and not among `taken`, to which it goes.
void check_entry_name(const FieldReader& reader, const std::string& name, std::size_t longest,
                      std::set<std::string>& taken);

/// "dof[3]".
[[nodiscard]] std::string entry(const char* list, int i);

}  // namespace haptic::server
