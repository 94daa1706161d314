#pragma once
/// What exists instead of a misspelt name, the likeliest first.

#include <google/protobuf/descriptor.h>

#include <string>

namespace haptic::server {

/// The fields of a message type as "a, b, c", nearest in spelling to `wanted`
/// first; "no fields" where the type has none.
[[nodiscard]] std::string fields_of(const google::protobuf::Descriptor& type,
                                    const std::string& wanted);

}  // namespace haptic::server
