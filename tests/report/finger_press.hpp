#pragma once
/// core/METHOD.md#forces-at-the-finger: a simulated finger that wears the exoskeleton presses
/// against stops at its joints, the real Pipeline renders them, in virtual time. The client sends
/// the clipped pose every tick.

#include <functional>

#include "haptic/core/tick/pipeline.hpp"
#include "hw/simulated/finger_physics.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {

inline constexpr double kNoStop = 999.0;           ///< deg: a joint without a stop
inline constexpr double kFingerForceLimit = 40.0;  ///< N, core/METHOD.md#forces-at-the-finger
inline constexpr double kFingerDamping = 2.0;      ///< N s/m, the simulated finger's own

/// The pipeline of a worn finger: no rendered damping, no slew limit, neither guard nor tank.
/// `stiffness`: Z_q, N/m. tests/report/STUDY.md#chosen-presses-finger_sign_change compares at Z_x =
/// Z_q/81.06^2, the mean of ||J_a|| on trajectory A. The renderers take the mean over the
/// workspace; the stiffness of the two baselines makes up for it.
[[nodiscard]] core::PipelineConfig finger_pipeline(std::shared_ptr<const core::Kinematics> finger,
                                                   core::RendererKind method, double stiffness);

/// Moves a worn finger on by the tick that ends at `t` s, in steps of 0.1 ms, as the simulated
/// device takes them: the hand aims at aim(t), rad, and tau (N) is held.
template <typename Aim>
void step_tick(hw::FingerPhysics& physics, double t, const Aim& aim, double tau) {
  constexpr int kSubsteps = 10;
  constexpr double dt = 1e-3 / kSubsteps;
  for (int s = kSubsteps - 1; s >= 0; --s) physics.step(dt, aim(t - s * dt), tau);
}

struct Press {
  Pair stop_deg{18.0, kNoStop};  ///< MCP, PIP
  Pair target_deg{50.0, 50.0};   ///< where the hand means to bring the joints
  double stiffness{1500.0};      ///< Z_q, N/m
  core::RendererKind method{core::RendererKind::kSubspaceLinear};
  bool direction_guard{false};
  bool energy_tank{false};  ///< strictly passive: tank_0 = 0, P_env = 0
                            ///< (core/METHOD.md#energy-tank)
  bool board{false};        ///< through the serial protocol and an emulated board with its L16
  bool force{true};         ///< false: the same without any force, for comparison
};

/// The finger's feeling in one tick.
struct PressTick {
  double t_s{0.0};
  Pair x_deg{};       ///< joints
  double tau_a{0.0};  ///< at the actuator, N; positive towards larger l_x
  double cell{0.0};   ///< what really acts on the linkage, N; tau_a itself without a board
  Pair tau_x{};       ///< that at the joints, w cell with w = (S J^-1)^T, N m, + flexes
};

struct Felt {
  PressTick end{};
  double max_penetration_deg{0.0};  ///< deepest beyond any stop, over the run; 0: never met one
  double peak_force{0.0};           ///< the tau_a of largest magnitude, with its sign, N
  double work{0.0};                 ///< J that the force put into the finger
  double net_work{0.0};             ///< the same less what the device's own damping took, J
  int withheld{0};                  ///< ticks in which the direction guard withheld the force
  double peak_cell{0.0};            ///< the force on the linkage of largest magnitude, N
  Pair peak_tau_x{};                ///< the torque of largest magnitude per joint, N m
  int throttled{0};                 ///< ticks in which the tank held a change back
};

/// 2 s of it. `observe` sees every tick. Throws SceneError where the force never came on.
[[nodiscard]] Felt press(const Press& what,
                         const std::function<void(const PressTick&)>& observe = {});

}  // namespace haptic::report
