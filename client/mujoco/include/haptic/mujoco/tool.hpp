#pragma once
/// haptic::mujoco - makes a MuJoCo simulation haptic: the part of the model that the device moves
/// follows the device by springs, and what it meets is told to hapticd as contacts.
///
///   haptic::mujoco::Tool finger(model, data, {joint("q_o1_mcp", 0), joint("q_o2_pip", 1)},
///                               {.coupling = 0.15});
///   session->engage_when_ready();
///   while (running) {
///     const auto state = session->wait_for_state();
///     session->publish(finger.step(state.x_probe, 1.0 / 60.0, session->round_trip()));
///   }
///
/// **The coupling.** In each bound coordinate a spring c w (x_probe - x) pulls the tool, with
/// critical damping against the probe's own rate, so that the tool does not lag in free motion; c
/// is `coupling`, w the scene's metric. They are generalised forces (qfrc_applied) and not a mocap
/// body with a weld: a weld's stiffness depends on the masses that it meets, and c must be known,
/// because the server solves the same balance. Weight and passive forces of the bound joints are
/// taken off, so only contacts hold the tool back. Their limits, friction and actuators are taken
/// off too: the hand that wears the device is where it is, whatever the model thinks.
///
/// **What moves with it.** Equalities and tendons that couple joints (a DIP that follows its PIP, a
/// closed chain) carry on the force of a contact: its gradient goes through them, and what bound
/// joints move by them is the tool, with all of the above.
///
/// **What is told is what holds the tool back.** Once a second both are compared, and mju_warning()
/// says where they differ by more than 2 %: friction, a weld to the world, a force of your own.
///
/// **What is published** is the balance x = x_probe + W^-1 sum J_i^T n_i f_i / c, with the normal
/// forces f_i that MuJoCo computed (mj_contactForce): the proxy of a tool without mass. In free
/// motion it is x_probe to the bit. Friction is not told.
///
/// Units are SI: m, rad, N, kg. Frame: MuJoCo's world.

#include <mujoco/mujoco.h>

#include <chrono>
#include <memory>
#include <vector>

#include "haptic/client/contact.hpp"
#include "haptic/mujoco/binding.hpp"

namespace haptic::mujoco {

struct ToolOptions {
  /// c > 0: N/m if x is in m, N m/rad if in rad. A force f displaces the proxy by f / c, and the
  /// device makes force of displacement. It is as large as f if c is the stiffness that it displays
  /// (w Z_q w^T: 0.15 N m/rad of a finger exoskeleton at 1500 N/m), magnified if c is smaller.
  double coupling{0.0};
  /// Diagonal of the scene's metric W, one per coordinate, > 0; empty: all 1. With `metric {
  /// scale_m scale_rad }` in the scene 1 / scale^2, and `coupling` is in J. A quaternion's four
  /// weigh alike: c w / 4 is the stiffness of the rotation, N m/rad.
  std::vector<double> weights{};
  /// A probe that is farther from the tool's aim than this, m or rad, is not followed at once: the
  /// client has just joined, or paused, or the device was moved meanwhile. The tool then comes at
  /// `slow_*`, m/s and rad/s, from where it was, so that it meets every object from the side that
  /// it was on; until it is there, nothing is told (Proxy::free()). The probe may be deep inside an
  /// object by then: what is told grows to the whole force within 200 ms.
  double jump_m{0.03}, jump_rad{0.35};
  double slow_m_s{0.5}, slow_rad_s{6.0};
  /// Actuators on joints that the device moves stay on, and hold the tool.
  bool keep_actuators{false};
};

/// The part of a model that the device moves: all bodies below a bound one, and those that bound
/// joints move by way of equalities and tendons. Contacts of their geoms with anything else, and
/// with each other, are told. Not safe for several threads.
class Tool {
 public:
  /// `model` and `data` stay the caller's, and must live longer. Changes in `model`: limits,
  /// friction and actuators of the tool's joints are off, and margin and gap of the tool's geoms
  /// grow by the horizon in which contacts are told, without a change of where force begins. A
  /// second joint of a coordinate may get armature. In `data` the tool writes qfrc_applied of its
  /// DoFs, and of DoFs that carry a bound site or body. Put forces of your own into xfrc_applied.
  /// Runs mj_forward.
  ///
  /// Throws std::invalid_argument, which names binding, value and what is allowed, for these: an
  /// unknown name, a joint that is bound twice, a coordinate that is so but by joints, has no
  /// weight or is not below 10000; a ball or free joint; a scale of 0; a coupling or a weight that
  /// is not above 0. It also throws for a spring too stiff for the model's step (step sqrt(c w / m)
  /// > 0.5).
  Tool(mjModel* model, mjData* data, const std::vector<Binding>& bindings,
       const ToolOptions& options);
  ~Tool();
  Tool(Tool&&) noexcept;
  Tool& operator=(Tool&&) noexcept;

  /// `period` s of simulated time by mj_step, and the sample to publish. `x_probe`: of the newest
  /// state, all coordinates of the device; if it is empty, not finite, or a pose's quaternion is
  /// shorter than 1e-3, the tool stays where it is, and the sample is Proxy::free(). `round_trip`:
  /// Session::round_trip(), for the horizon in which contacts are told before they touch.
  client::Proxy step(const std::vector<double>& x_probe, double period,
                     std::chrono::nanoseconds round_trip = {});

  // The same in parts, for a loop that calls mj_step itself:
  //   tool.aim(x_probe, 16, round_trip);
  //   for (int i = 0; i < 16; ++i) { tool.pull(); mj_step(model, data); }
  //   session->publish(tool.proxy());

  /// Where the tool is to be after `steps` (> 0) steps.
  void aim(const std::vector<double>& x_probe, int steps, std::chrono::nanoseconds round_trip = {});
  /// Sets qfrc_applied for the next mj_step. Before every one: after a step without it the tool
  /// begins again, see restart().
  void pull();
  /// The proxy of the contacts that the last mj_step found.
  [[nodiscard]] client::Proxy proxy();

  /// The tool begins again where the model has it, as a late join: until it came to the probe, see
  /// ToolOptions::jump_m, nothing is told, and what it is inside of does not count. Call it after
  /// you moved the model yourself (qpos). It happens by itself if data->time is not that of the
  /// next step: after mj_resetData, a key of another time, a bad state, or steps without pull().
  /// Runs mj_forward.
  void restart();

  /// True if the tool follows the probe; false: it is on its way there, see ToolOptions::jump_m.
  [[nodiscard]] bool following() const noexcept;
  /// True of the model's bodies that are the tool's.
  [[nodiscard]] bool moves(int body) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace haptic::mujoco
