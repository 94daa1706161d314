#pragma once
/// The picture of a device as a message.

#include "haptic/core/model/drawing.hpp"
#include "haptic/v1/drawing.pb.h"

namespace haptic::server {

[[nodiscard]] v1::Drawing to_message(const core::Drawing& drawing);

}  // namespace haptic::server
