#pragma once
/// What it spares the loop to leave out the fingers that nothing can hold (core/README.md): a hand
/// of five that closes and opens, one finger on its plane, four free.

namespace haptic::bench {

/// Prints a tick that leaves the free ones out, f of which the telemetry drain asks for, against
/// the same with that work in the tick, by Eq. (8) and by Eq. (6); then, as a comment, whether the
/// completed records have f(q) of every finger.
void print_free_fingers();

}  // namespace haptic::bench
