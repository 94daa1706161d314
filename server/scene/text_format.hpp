#pragma once
/// A scene's text into its message, with positions; errors say file, line, column, and for an
/// unknown field what there is instead.

#include <google/protobuf/text_format.h>

#include <string>

#include "haptic/v1/scene.pb.h"

namespace haptic::server {

/// Throws SceneError.
void parse_text(const std::string& text, const std::string& name, v1::Scene& message,
                google::protobuf::TextFormat::ParseInfoTree& tree);

/// The fields of a message type, closest in spelling to `wanted` first: "a, b, c".
[[nodiscard]] std::string fields_of(const google::protobuf::Descriptor& type,
                                    const std::string& wanted);

}  // namespace haptic::server
