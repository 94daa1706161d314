#pragma once
/// Energy over a path of the device, the test the paper lacks
/// (tests/report/STUDY.md#cyclic-energy-finger_sign_change and
/// tests/report/STUDY.md#finite-difference-rule-finger_sign_change): a force that is the gradient
/// of a potential does no work around a closed cycle, whichever way it is run. Trapezoidal rule.
/// One actuated DoF; works of several DoFs add up.

#include <span>

namespace haptic::core {

enum class Direction { kForward, kReversed };

/// Work done on the user around the closed polygon of the samples, whose last joins the first.
/// Positive: the device gave energy. Unit of tau_a times that of q_a.
[[nodiscard]] double cycle_work(std::span<const double> q_a, std::span<const double> tau_a,
                                Direction direction = Direction::kForward) noexcept;

/// Lowest value of the running energy that the device has taken in since the first sample, E = -
/// integral of tau_a dq_a; 0 or less. Passive for this path: never below -V(0), the energy stored
/// in the spring at the start.
[[nodiscard]] double lowest_running_energy(std::span<const double> q_a,
                                           std::span<const double> tau_a) noexcept;

}  // namespace haptic::core
