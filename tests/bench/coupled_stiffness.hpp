#pragma once
/// What a Z_q that couples the actuators costs in a tick, and what it is for
/// (core/METHOD.md#actuator-limits): the desk stylus of the scene stylus_cartesian, 200 N/m at the
/// wrist in every direction of space.

namespace haptic::bench {

/// Prints a tick with that Z_q against one with its diagonal alone, without and with tank and
/// observer; then, as a comment, the errors of the two choices that it spares: the diagonal's
/// stiffness in space, and the work per cycle of a clamp of each actuator by itself.
void print_coupled_stiffness();

}  // namespace haptic::bench
