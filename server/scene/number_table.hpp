#pragma once
/// Reads optional numbers of a message into a struct by a table of NumberField; absent ones get the
/// struct's default, in the message as well.

#include <cmath>
#include <string>

#include "server/scene/finger_fields.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// False where a value is not allowed; it has gone to `problems`.
template <typename Struct, std::size_t N>
bool read_numbers(google::protobuf::Message& message, const std::string& path,
                  const NumberField<Struct> (&table)[N], Struct& into, Problems& problems) {
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  bool good = true;
  for (const NumberField<Struct>& entry : table) {
    const auto* field = message.GetDescriptor()->FindFieldByName(entry.name);
    double& value = entry.at(into);
    if (!reflection.HasField(message, field)) {
      reflection.SetDouble(&message, field, value);
      continue;
    }
    value = reflection.GetDouble(message, field);
    if (!std::isfinite(value) || value < entry.lowest) {
      problems.add(path + "." + entry.name, value,
                   entry.lowest == kAny ? "must be finite" : "must be finite and >= 0");
      good = false;
    }
  }
  return good;
}

}  // namespace haptic::server
