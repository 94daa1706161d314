#pragma once
/// The server's messages as JSON, every field by its name: --json prints them so.

#include <nlohmann/json.hpp>

#include "google/protobuf/message.h"

namespace haptic::ctl {

/// An enum's value is its name, a set of bits the list of their names, a duration a number of us
/// with "_us" behind the field's name. Null: an absent message, or a number that JSON has not.
[[nodiscard]] nlohmann::json to_json(const google::protobuf::Message& message);

}  // namespace haptic::ctl
