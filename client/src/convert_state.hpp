#pragma once
/// DeviceState from and to its message: made of the message's fields (proto/generate).

#include "haptic/client/state.hpp"
#include "haptic/v1/session.pb.h"

namespace haptic::client {

/// Fills the fields of a `to` that holds the defaults.
void read(const v1::DeviceState& from, DeviceState& to);
void write(const DeviceState& from, v1::DeviceState& to);

}  // namespace haptic::client
