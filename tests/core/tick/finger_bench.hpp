#pragma once
/// A pipeline with the finger exoskeleton, driven in virtual time at 1 kHz: device and client in
/// one hand. The finger is where put() says, the proxy where `target` says.

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/core/tick/driven.hpp"
#include "tests/support/pressing_hand.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core::test {

inline constexpr double kStiffness = 1500.0, kForceLimit = 20.0;

inline VecX joints(double mcp, double pip) {
  return two(mcp, pip);
}

inline PipelineConfig config_of(RendererKind renderer) {
  PipelineConfig c = pressing_config(make_finger_exoskeleton(finger_sign_change()), renderer);
  c.device.q_lower = two(-0.0025, -1.5);
  c.device.q_upper = two(0.0525, 0.85);
  c.scene.damping = one(0.0);
  c.scene.slew_limit = one(1e6);
  c.scene.engage_window = one(40.0);
  return c;
}

inline PipelineConfig with_tank(RendererKind renderer, double initial) {
  PipelineConfig c = config_of(renderer);
  c.passivity.tank.enabled = true;
  c.passivity.tank.initial = initial;
  return c;
}

class Bench : public DrivenPipeline {
 public:
  explicit Bench(const PipelineConfig& config) : DrivenPipeline(config) { put(joints(0.5, 0.5)); }
  void put(const VecX& x) {
    EXPECT_EQ(pipeline.config().kinematics->inverse(x, input.device.sample.q),
              InverseStatus::kExact);
  }

  ProxyMode mode{ProxyMode::kHeld};
  VecX target = joints(0.5, 0.5);
  ProxySnapshot (*shape)(ProxySnapshot){nullptr};  ///< changes each sample; none: as it is

 protected:
  void prepare() override {
    proxy.mode = mode;
    proxy.x = target;
    if (shape) proxy = shape(proxy);
  }
};

}  // namespace haptic::core::test
