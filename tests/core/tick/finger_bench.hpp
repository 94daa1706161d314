#pragma once
/// A pipeline with the finger exoskeleton, driven in virtual time at 1 kHz: device and client in
/// one hand. The finger is where put() says, the proxy where `target` says.

#include <gtest/gtest.h>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/tick/pipeline.hpp"

namespace haptic::core::test {

inline constexpr double kStiffness = 1500.0, kForceLimit = 20.0;

inline VecX joints(double mcp, double pip) {
  return (VecX(2) << mcp, pip).finished();
}

inline PipelineConfig config_of(RendererKind renderer) {
  PipelineConfig c;
  c.kinematics = make_finger_exoskeleton({});
  c.device.q_lower = (VecQ(2) << -0.0025, -1.5).finished();
  c.device.q_upper = (VecQ(2) << 0.0525, 0.85).finished();
  c.device.max_effort = VecA::Constant(1, 40.0);
  c.scene.renderer = renderer;
  c.scene.stiffness = VecA::Constant(1, kStiffness);
  c.scene.damping = VecA::Zero(1);
  c.scene.force_limit = VecA::Constant(1, kForceLimit);
  c.scene.slew_limit = VecA::Constant(1, 1e6);
  c.scene.engage_window = VecA::Constant(1, 40.0);
  return c;
}

inline PipelineConfig with_tank(RendererKind renderer, double initial) {
  PipelineConfig c = config_of(renderer);
  c.passivity.tank.enabled = true;
  c.passivity.tank.initial = initial;
  return c;
}

class Bench {
 public:
  explicit Bench(const PipelineConfig& config) : pipeline(config) {
    input.settings = config.scene;
    input.device.armed = true;
    input.device.fresh = true;
    input.command.tenure = 1;
    input.command.lease_held = true;
    put(joints(0.5, 0.5));
  }
  void put(const VecX& x) {
    EXPECT_EQ(pipeline.config().kinematics->inverse(x, input.device.sample.q),
              InverseStatus::kExact);
  }
  TickRecord tick() {
    input.now += std::chrono::milliseconds(1);
    ++input.device.sample.seq;
    input.device.sample.time = input.now;
    ProxySnapshot& p = input.proxy;
    p.mode = ProxyMode::kHeld;
    p.tenure = 1;
    p.x = target;
    if (p.gapless_samples++ == 0) p.gapless_since = input.now;
    ++p.seq;
    p.born = input.now;
    if (shape) p = shape(p);
    return pipeline.tick(input);
  }
  TickRecord engage() {
    for (int i = 0; i < 250; ++i) tick();
    ++input.command.engage_id;
    TickRecord record = tick();
    EXPECT_EQ(record.life.engage.verdict, EngageVerdict::kAccepted);
    for (int i = 0; i < 205; ++i) record = tick();
    EXPECT_EQ(record.life.state, LifecycleState::kEngaged);
    return record;
  }

  Pipeline pipeline;
  TickInput input{};
  VecX target = joints(0.5, 0.5);
  ProxySnapshot (*shape)(ProxySnapshot){nullptr};  ///< changes each sample; none: as it is
};

inline constexpr RendererKind kAllRenderers[] = {RendererKind::kStandard, RendererKind::kNullSpace,
                                                 RendererKind::kSubspaceLinear,
                                                 RendererKind::kSubspaceExact};

}  // namespace haptic::core::test
