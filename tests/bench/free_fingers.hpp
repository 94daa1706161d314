#pragma once
/// What it saves a tick to leave out the fingers that nothing can hold (core/README.md): a hand of
/// five, one finger on its plane, four that move freely.

namespace haptic::bench {

/// Prints a tick that leaves them out against one that asks for f of all five, by Eq. (8) and by
/// Eq. (6); then, as a comment, by how much the completed records of the two differ.
void print_free_fingers();

}  // namespace haptic::bench
