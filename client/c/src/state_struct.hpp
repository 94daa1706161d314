#pragma once
/// The struct of a state: filled by what is made of the message's fields (proto/generate).

#include "haptic/client/state.hpp"
#include "structs.hpp"

namespace haptic::c {

/// `to` is all 0.
void write(const client::DeviceState& from, haptic_state& to);

}  // namespace haptic::c
