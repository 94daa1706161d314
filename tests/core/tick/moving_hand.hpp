#pragma once
/// A hand of five fingers that all move, in virtual time at 1 kHz: device and client in one.

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <utility>

#include "haptic/core/model/block_set.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/core/tick/finger_bench.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core::test {

inline constexpr int kFingers = 5;
inline constexpr BlockSet kAllFingers = (1u << kFingers) - 1;
inline constexpr double kFar = 1e3;  // rad; no finger bends that far

inline PipelineConfig hand_config(RendererKind renderer, bool guarded, bool certified = false) {
  PipelineConfig c;
  c.kinematics = make_hand_exoskeleton(five_fingers());
  c.device.q_lower = VecQ::Constant(2 * kFingers, -2.0);
  c.device.q_upper = VecQ::Constant(2 * kFingers, 2.0);
  c.device.max_effort = VecA::Constant(kFingers, 40.0);
  c.scene.renderer = renderer;
  c.scene.direction_guard = guarded;
  c.passivity.tank.enabled = guarded;
  c.passivity.tank.initial = 1e-3;
  c.passivity.observer.enabled = guarded;
  c.passivity.device_damping = VecA::Constant(kFingers, 2.0);
  c.passivity.observer.inertia = VecA::Constant(kFingers, 0.05);
  c.passivity_certificate = certified;
  c.scene.stiffness = VecA::LinSpaced(kFingers, 800.0, 1600.0);
  c.scene.damping = VecA::Constant(kFingers, 2.0);
  c.scene.force_limit = VecA::Constant(kFingers, kForceLimit);
  c.scene.slew_limit = VecA::Constant(kFingers, 2000.0);
  c.scene.engage_window = VecA::Constant(kFingers, 1e3);
  return c;
}

/// One hand in virtual time, whose fingers all move; the proxy is what `sample` was set to last.
class MovingHand {
 public:
  explicit MovingHand(const PipelineConfig& config) : map(*config.kinematics) {
    input.settings = config.scene;
    input.device.armed = input.device.fresh = true;
    input.command.lease_epoch = 1;
    input.command.lease_held = true;
    input.proxy.epoch = 1;
    sample(ProxyMode::kFree);
  }
  void advance() {
    const double phase = 0.02 * n_++;
    VecX angles(2 * kFingers);
    for (int f = 0; f < kFingers; ++f) {
      angles[2 * f] = 0.4 + 0.12 * std::sin(phase + f);
      angles[2 * f + 1] = 0.5 + 0.12 * std::sin(1.3 * phase + 2 * f);
    }
    EXPECT_EQ(map.inverse(angles, input.device.sample.q), InverseStatus::kExact);
    input.now += std::chrono::milliseconds(1);
    ++input.device.sample.seq;
    input.device.sample.time = input.now;
    input.command.engage_id = n_ > 260 ? 1 : 0;
  }
  /// A new frame of the client.
  ProxySnapshot& sample(ProxyMode mode) {
    ProxySnapshot& p = input.proxy;
    p.mode = mode;
    if (++p.seq == 1) p.gapless_since = input.now;
    ++p.gapless_samples;
    p.born = input.now;
    p.x = input.device.sample.q.size() > 0 ? probe() : VecX(VecX::Zero(2 * kFingers));
    p.planes = {};
    return p;
  }
  [[nodiscard]] VecX probe() const {
    VecX x;
    MatXQ J;
    EXPECT_EQ(map.evaluate(input.device.sample.q, x, J), MapStatus::kOk);
    return x;
  }

  const Kinematics& map;
  TickInput input{};

 private:
  int n_{0};
};

/// core/METHOD.md#map-without-a-value: the finger's linkage has no configuration there.
inline void break_finger(int finger, TickInput& input) {
  input.device.sample.q.segment<2>(2 * finger) << 0.02, -101 * kDegree;
}

/// One plane per finger of `fingers`, on its second joint, `depth` (rad) into where the hand is.
inline void planes_into(MovingHand& hand, std::initializer_list<std::pair<int, double>> fingers) {
  ProxySnapshot& p = hand.sample(ProxyMode::kPlanes);
  const auto count = static_cast<Eigen::Index>(fingers.size());
  p.planes.normals.setZero(p.x.size(), count);
  p.planes.offsets.setZero(count);
  int k = 0;
  for (const auto& [finger, depth] : fingers) {
    p.planes.normals(2 * finger + 1, k) = 1.0;
    p.planes.offsets[k++] = p.x[2 * finger + 1] - depth;
  }
}

/// No spring is stretched in these fingers: q* = q to the bit.
inline bool unstretched(const TickRecord& record, BlockSet fingers) {
  for (int k = 0; k < 2 * kFingers; ++k) {
    const bool asked = (fingers >> (k / 2) & 1u) != 0;
    if (asked && record.q_star[k] != record.q[k]) return false;
  }
  return true;
}

}  // namespace haptic::core::test
