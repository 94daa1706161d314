#pragma once
/// A finger on an emulated board that its hand bends into an object: the tick's pipeline on the
/// board's protocol, firmware and rig, in virtual time.

#include <chrono>
#include <functional>
#include <memory>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "tests/support/held_proxy.hpp"
#include "tests/support/virtual_board.hpp"

namespace haptic::test {

/// Who closes the loop on the force, with the gains of hw/README.md.
struct ForceLaw {
  const char* name{};
  hw::emulator::BoardControl control{};
  core::ForceControlSettings settings{};
};
inline const ForceLaw kServerLoop{
    "server {}", hw::emulator::BoardControl::kDrive, {{{20.0, 100.0, 15.0, 2.0, 50.0}}, {}}};
inline const ForceLaw kAdmittance{"admittance {}",
                                  hw::emulator::BoardControl::kPosition,
                                  {{}, {{0.0, 150.0, 0.03, 0.0, 0.0335}}}};

struct PressedBoardSetup {
  hw::emulator::EmulatorConfig emulator{};
  std::shared_ptr<const core::Kinematics> finger = core::make_finger_exoskeleton({});
  Eigen::Vector2d aim{0.9, 0.9};  ///< rad, where the hand takes the joints
  /// The proxy of a finger that is at `probe`, rad.
  std::function<core::VecX(const core::VecX& probe)> proxy{};
  double max_effort{40.0};     ///< N
  double stiffness{500.0};     ///< N/m
  double damping{0.5};         ///< N s/m
  double engage_window{20.0};  ///< N
  bool direction_guard{true};
  core::ForceControlSettings force_control{};
};

class PressedBoard {
 public:
  static constexpr double kForceLimit = 20.0;  // N

  explicit PressedBoard(const PressedBoardSetup& setup)
      : setup_(setup),
        device_(setup.emulator, {Eigen::Vector2d::Zero(), setup.aim}, wanted(setup), setup.finger),
        pipeline_(pipeline_config()) {
    input_.settings = pipeline_.config().scene;
    input_.command.tenure = 1;
    input_.command.lease_held = true;
  }

  const core::TickRecord& tick() {
    input_.now += std::chrono::milliseconds(1);
    device_.read(input_.now, input_.device);
    core::VecX x;
    core::MatXQ J;
    if (input_.device.sample.q.size() == 2 &&
        setup_.finger->evaluate(input_.device.sample.q, x, J) == core::MapStatus::kOk) {
      publish_held(input_, setup_.proxy(x), proxy_);
    }
    if (last_.life.state == core::LifecycleState::kArmed) ++input_.command.engage_id;
    last_ = pipeline_.tick(input_, proxy_);
    const core::VecA& drive = last_.effort.drive;
    device_.write(input_.now, {last_.life.arm, drive.size() > 0 ? drive : last_.effort.tau_a,
                               last_.effort.position});
    return last_;
  }
  const core::TickRecord& run_ms(int ms) {
    for (int i = 0; i < ms; ++i) tick();
    return last_;
  }
  void clear() {
    ++input_.command.clear_id;
    input_.command.clear = last_.faults();
  }
  [[nodiscard]] hw::emulator::VirtualBoard& device() { return device_; }
  [[nodiscard]] hw::emulator::EmulatedBoard& board() { return device_.board(); }
  [[nodiscard]] const core::TickRecord& last() const { return last_; }

 private:
  static hw::BoardConfig wanted(const PressedBoardSetup& setup) {
    hw::BoardConfig config;
    config.max_effort = core::VecA::Constant(1, setup.max_effort);
    return config;
  }
  [[nodiscard]] core::PipelineConfig pipeline_config() const {
    core::PipelineConfig config{.kinematics = setup_.finger, .device = device_.info().limits};
    config.scene.direction_guard = setup_.direction_guard;
    config.scene.stiffness = core::VecA::Constant(1, setup_.stiffness);
    config.scene.damping = core::VecA::Constant(1, setup_.damping);
    config.scene.force_limit = core::VecA::Constant(1, kForceLimit);
    config.scene.slew_limit = core::VecA::Constant(1, 2000.0);
    config.scene.engage_window = core::VecA::Constant(1, setup_.engage_window);
    config.force_control = setup_.force_control;
    return config;
  }

  PressedBoardSetup setup_;
  hw::emulator::VirtualBoard device_;
  core::Pipeline pipeline_;
  core::TickInput input_{};
  core::ProxySnapshot proxy_{};
  core::TickRecord last_{};
};

}  // namespace haptic::test
