#pragma once
/// A finger that wears the exoskeleton, the real Pipeline and a client behind a network, in virtual
/// time (core/METHOD.md#results): how much energy the force gives per cycle.
///
/// The finger stands still at its ease while force is switched on, goes to where the motion begins,
/// and does it: kCycles times in a second each, or presses once.

#include <functional>

#include "haptic/core/tick/pipeline.hpp"
#include "tests/report/values.hpp"
#include "tests/support/loop/remote_client.hpp"

namespace haptic::report {

enum class Motion {
  kCycle,  ///< headline 1: the device is led, l_x +-2 mm and q_B +-0.05 rad about x = (30, 30) deg
  kHand,   ///< 5.3: the hand aims at (35 + 15 cos, 35 + 15 sin) deg, the finger is free to follow
  kPress,  ///< 2.4: the hand aims at (50, 50) deg and stays
};
inline constexpr int kCycles = 4;  ///< core/METHOD.md#energy-tank; the last one is reported

enum class Safeguard { kNothing, kGuard, kGuardTank };

[[nodiscard]] inline std::string_view name(Motion motion) noexcept {
  return name_in({"cycle", "hand", "press"}, motion);
}
[[nodiscard]] inline std::string_view name(Safeguard with) noexcept {
  return name_in({"nothing", "guard", "guard_tank"}, with);
}

struct FingerLoop {
  Motion motion{Motion::kHand};
  bool reversed{false};  ///< the cycle the other way round; a press has none
  core::RendererKind method{core::RendererKind::kSubspaceLinear};
  double stiffness{1500.0};  ///< Z_q, N/m
  Safeguard with{Safeguard::kNothing};
  double tank_initial{0.0};       ///< J
  test::ClientSettings client{};  ///< its stops in rad
};

struct LoopTick {
  double t_s{0.0};    ///< since the motion began; negative before
  Pair x_deg{};       ///< joints
  double tau_a{0.0};  ///< N
  double given{0.0};  ///< to the user since force came on, J
  double net{0.0};    ///< less what the device's own damping took
};

/// Figures of the last cycle, or the press; J, N. Positive work: given to the user.
struct LoopFigures {
  double given{0.0};
  double net{0.0};           ///< less what the device's own damping took
  double most_net{0.0};      ///< largest over time since force came on: what the tank bounds
  double peak_storage{0.0};  ///< V of the spring in use, largest
  double mean_force{0.0};    ///< of the magnitude
  double peak_force{0.0};    ///< of the magnitude
  double max_penetration_deg{0.0};
  int ticks{0};
  int withheld{0};   ///< ticks, by the guard
  int throttled{0};  ///< ticks: tank, since force came on
};

/// `observe` sees every tick. Throws SceneError where force never came on.
[[nodiscard]] LoopFigures run(const FingerLoop& what,
                              const std::function<void(const LoopTick&)>& observe = {});

}  // namespace haptic::report
