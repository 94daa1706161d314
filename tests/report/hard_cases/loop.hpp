#pragma once
/// The finger in a whole tick, in virtual time at 1 kHz.

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/tick/pipeline.hpp"

namespace haptic::report {

/// A pipeline with the device and the client played by the case, in virtual time.
class Loop {
 public:
  Loop(core::RendererKind kind, double stiffness, const core::PassivitySettings& passivity = {})
      : pipeline_(config(kind, stiffness, passivity)) {
    input.settings = pipeline_.config().scene;
    input.command.lease_epoch = 1;
    input.command.lease_held = true;
    input.device.armed = true;
  }
  core::TickRecord tick(const core::VecQ& q, const core::VecX& x) {
    input.now += std::chrono::milliseconds(1);
    input.device.fresh = true;
    ++input.device.sample.seq;
    input.device.sample.time = input.now;
    input.device.sample.q = q;
    core::ProxySnapshot& proxy = input.proxy;
    proxy.mode = core::ProxyMode::kHeld;
    proxy.epoch = 1;
    proxy.born = input.now;
    if (++proxy.seq == 1) proxy.gapless_since = input.now;
    ++proxy.gapless_samples;
    proxy.x = x;
    return pipeline_.tick(input);
  }
  /// ENGAGED with g = 1.
  core::TickRecord engage(const core::VecQ& q, const core::VecX& x) {
    for (int i = 0; i < 250; ++i) static_cast<void>(tick(q, x));
    ++input.command.engage_id;
    core::TickRecord record;
    for (int i = 0; i < 250; ++i) record = tick(q, x);
    return record;
  }
  core::TickInput input{};

 private:
  static core::PipelineConfig config(core::RendererKind kind, double stiffness,
                                     const core::PassivitySettings& passivity) {
    core::PipelineConfig c;
    c.passivity = passivity;
    c.kinematics = core::make_finger_exoskeleton({});
    c.device.q_lower = (core::VecQ(2) << -0.0025, -3.0).finished();
    c.device.q_upper = (core::VecQ(2) << 0.0525, 0.85).finished();
    c.device.max_effort = core::VecA::Constant(1, 40.0);
    c.scene.renderer = kind;
    c.scene.direction_guard = true;
    c.scene.stiffness = core::VecA::Constant(1, stiffness);
    c.scene.damping = core::VecA::Constant(1, 2.0);
    c.scene.force_limit = core::VecA::Constant(1, 20.0);
    c.scene.slew_limit = core::VecA::Constant(1, 1e6);
    c.scene.engage_window = core::VecA::Constant(1, 20.0);
    return c;
  }
  core::Pipeline pipeline_;
};

}  // namespace haptic::report
