#pragma once
/// Fields that a contact and its plane have by the same name.

#include "haptic/client/contact.hpp"

namespace haptic::client {

/// Generated: copies these fields; what is felt by way of the coupling is divided by its stiffness.
void tell(const Contact& from, double coupling, Plane& to);

}  // namespace haptic::client
