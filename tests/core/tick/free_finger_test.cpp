// Fingers of a hand that nothing can hold (core/METHOD.md#model-only-what-a-scene-needs): they cost
// no J and no solve, nothing pulls them, and one whose linkage cannot close disturbs no other.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "core/src/tick/rendering.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/core/tick/finger_bench.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/pressing_hand.hpp"

namespace haptic::core {
namespace {

using test::DrivenPipeline;
using test::joints;

constexpr int kFingers = 5;
constexpr BlockSet kAllFingers = (1u << kFingers) - 1;
constexpr double kFar = 1e3;  // rad; no finger bends that far

/// Five fingers that all move, at the rendering stage.
class FreeFinger : public testing::Test {
 protected:
  FreeFinger() { advance(); }
  void advance() {
    const double phase = 0.02 * n_++;
    VecX angles(2 * kFingers);
    for (int f = 0; f < kFingers; ++f) {
      angles[2 * f] = 0.4 + 0.12 * std::sin(phase + f);
      angles[2 * f + 1] = 0.5 + 0.12 * std::sin(1.3 * phase + 2 * f);
    }
    EXPECT_EQ(map->inverse(angles, sensed.q), InverseStatus::kExact);
    sensed.ready = true;
  }
  [[nodiscard]] VecX probe() const {
    VecX x;
    EXPECT_EQ(map->position(sensed.q, x), MapStatus::kOk);
    return x;
  }
  void sample_as(ProxyMode mode) {
    sample.mode = mode;
    ++sample.seq;
    sample.x = probe();
    sample.planes = {};
  }
  /// One plane per finger, on its second joint, `depth` (rad) into where the hand is.
  void planes_into(std::initializer_list<std::pair<int, double>> fingers) {
    sample_as(ProxyMode::kPlanes);
    const auto count = static_cast<Eigen::Index>(fingers.size());
    sample.planes.normals.setZero(2 * kFingers, count);
    sample.planes.offsets.setZero(count);
    int k = 0;
    for (const auto& [finger, depth] : fingers) {
      sample.planes.normals(2 * finger + 1, k) = 1.0;
      sample.planes.offsets[k++] = sample.x[2 * finger + 1] - depth;
    }
  }
  /// core/METHOD.md#map-without-a-value: its linkage has no configuration there.
  void break_finger(int finger) { sensed.q.segment<2>(2 * finger) << 0.02, -101 * kDegree; }
  Anchor step(Rendering& rendering) {
    const Anchor now = rendering.step({}, sensed, sample, settings, in_use);
    in_use = now.q_star;
    return now;
  }
  /// q* = q in these fingers, to the bit.
  [[nodiscard]] bool unstretched(const Anchor& now, BlockSet fingers) const {
    for (int k = 0; k < 2 * kFingers; ++k) {
      if ((fingers >> (k / 2) & 1u) != 0 && now.q_star[k] != sensed.q[k]) return false;
    }
    return true;
  }

  std::shared_ptr<const Kinematics> map = make_hand_exoskeleton(five_fingers());
  PipelineConfig config = pressing_config(map, RendererKind::kSubspaceLinear);
  ProjectionModel model{*map};
  Settings settings{config.scene, {}};
  Sensed sensed{};
  ProxySnapshot sample{};
  VecQ in_use = VecQ::Zero(2 * kFingers);

 private:
  int n_{0};
};

TEST_F(FreeFinger, FreeIfNoProxyCanHold) {
  Rendering rendering(model, config);
  sample_as(ProxyMode::kFree);
  EXPECT_EQ(step(rendering).free, kAllFingers);
  planes_into({{0, 0.05}, {3, -kFar}});
  EXPECT_EQ(step(rendering).free, kAllFingers & ~0b01001u) << "in the way or not";
  sample_as(ProxyMode::kHeld);
  EXPECT_EQ(step(rendering).free, 0u);
  sample = {};
  EXPECT_EQ(step(rendering).free, kAllFingers);
}

TEST_F(FreeFinger, TiedOrSingleAreNeverFree) {
  Eigen::MatrixXd W = Eigen::MatrixXd::Identity(2 * kFingers, 2 * kFingers);
  W(1, 3) = W(3, 1) = 0.3;
  config.projection.metric = TaskMetric::from_matrix(W);
  const ProjectionModel tied(*map, config.projection);
  Rendering all(tied, config);
  sample_as(ProxyMode::kFree);
  EXPECT_EQ(step(all).free, 0u);
  const PipelineConfig alone = pressing_config(equal_fingers(1), RendererKind::kSubspaceLinear);
  const ProjectionModel one(*alone.kinematics);
  Rendering single(one, alone);
  sensed.q = VecQ(sensed.q.head(2));
  EXPECT_EQ(single.step({}, sensed, sample, {alone.scene, {}}, sensed.q).free, 0u);
}

/// A plane far away on all fingers names them all, and changes nothing but that.
TEST_F(FreeFinger, FarPlaneChangesNothing) {
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const RendererKind kind : kEveryRenderer) {
    for (const bool guard : {false, true}) {
      SCOPED_TRACE(std::string(name(kind)) + (guard ? " guarded" : ""));
      settings.renderer = kind;
      settings.direction_guard = guard;
      Rendering lean(model, config), full(model, config);
      VecQ lean_in_use = in_use, full_in_use = in_use;
      int pressed = 0;
      for (int i = 0; i < 600; ++i) {
        advance();
        if (i % 8 == 0) {
          const int a = static_cast<int>(kFingers * unit(random));
          const int b = static_cast<int>(kFingers * unit(random));
          planes_into({{a, 0.1 * (unit(random) - 0.4)}, {b, 0.1 * (unit(random) - 0.4)}});
        }
        const Anchor now = lean.step({}, sensed, sample, settings, lean_in_use);
        ProxySnapshot naming = sample;
        naming.planes.normals.conservativeResize(2 * kFingers, 3);
        naming.planes.normals.col(2).setOnes();
        naming.planes.offsets.conservativeResize(3);
        naming.planes.offsets[2] = kFar;
        const Anchor all = full.step({}, sensed, naming, settings, full_in_use);
        ASSERT_EQ(all.free, 0u);
        ASSERT_NE(now.free, 0u);
        ASSERT_EQ(now.x_probe, all.x_probe);
        ASSERT_EQ(now.x, all.x);
        ASSERT_EQ(now.q_star, all.q_star) << i;
        ASSERT_EQ(now.projection, all.projection);
        ASSERT_EQ(now.condition, all.condition);
        ASSERT_TRUE(unstretched(now, now.free));
        pressed += now.in_the_way ? 1 : 0;
        lean_in_use = now.q_star;
        full_in_use = all.q_star;
      }
      EXPECT_GT(pressed, 100);
    }
  }
}

TEST_F(FreeFinger, FreeFingersFailureDisturbsNoOther) {
  Rendering sound(model, config), broken(model, config);
  planes_into({{0, 0.05}});
  const Anchor before = step(broken);
  for (int i = 0; i < 50; ++i) {
    advance();
    const Anchor expected = step(sound);
    break_finger(2);
    const Anchor now = step(broken);
    ASSERT_TRUE(now.mapped && now.anchored);
    ASSERT_EQ(now.projection, expected.projection);
    ASSERT_EQ(now.q_star.head(2), expected.q_star.head(2));
    ASSERT_TRUE(unstretched(now, kAllFingers & ~1u));
    ASSERT_EQ(now.x_probe.segment(4, 2), before.x_probe.segment(4, 2)) << "the last that it had";
    ASSERT_EQ(now.x.segment(4, 2), now.x_probe.segment(4, 2));
    ASSERT_EQ(now.x_probe.tail(4), expected.x_probe.tail(4));
  }
}

TEST_F(FreeFinger, PressedFingersFailureKeepsItsAnchor) {
  for (const RendererKind kind : kEveryRenderer) {
    SCOPED_TRACE(std::string(name(kind)));
    settings.renderer = kind;
    Rendering rendering(model, config);
    advance();
    planes_into({{0, 0.05}});
    const VecQ anchor = step(rendering).q_star;
    for (int i = 0; i < 50; ++i) {
      advance();
      break_finger(0);
      const Anchor now = step(rendering);
      ASSERT_EQ(now.projection, ProjectionStatus::kMapFailed);
      ASSERT_EQ(now.q_star.head(2), anchor.head(2)) << "its spring stays alive";
      ASSERT_TRUE(unstretched(now, kAllFingers & ~1u)) << i;
    }
  }
}

TEST_F(FreeFinger, NoForwardMapMeansNoSpring) {
  Rendering rendering(model, config);
  planes_into({{0, 0.05}, {2, 0.05}});
  const ProxySnapshot named = sample;
  planes_into({{0, 0.05}});
  static_cast<void>(step(rendering));
  break_finger(2);
  static_cast<void>(step(rendering));
  const VecQ nowhere = sensed.q;
  sample = named;
  for (int i = 0; i < 5; ++i) {
    sensed.q = nowhere;
    sensed.q[4] += 1e-4 * i;
    const Anchor now = step(rendering);
    EXPECT_EQ(now.projection, ProjectionStatus::kMapFailed);
    EXPECT_EQ(now.free, kAllFingers & ~1u) << "until it closes";
    EXPECT_TRUE(unstretched(now, now.free));
  }
  advance();
  const Anchor healed = step(rendering);
  EXPECT_EQ(healed.free, kAllFingers & ~0b101u);
  EXPECT_NE(healed.projection, ProjectionStatus::kMapFailed);
  EXPECT_FALSE(unstretched(healed, 0b100u));
}

/// Some equal fingers in virtual time: the first presses on stops and moves, the second moves
/// freely, the third rests. The proxy is what a client on this machine would send, held or as
/// planes.
class Hand : public DrivenPipeline {
 public:
  Hand(int fingers, RendererKind renderer, ProxyMode mode, bool guard = false)
      : DrivenPipeline(config(equal_fingers(fingers), renderer, guard)) {
    proxy.mode = mode;
  }

 private:
  static PipelineConfig config(const std::shared_ptr<const Kinematics>& map, RendererKind renderer,
                               bool guard) {
    PipelineConfig c = pressing_config(map, renderer);
    c.scene.direction_guard = guard;
    c.scene.slew_limit.setConstant(1e6);
    return c;
  }
  void prepare() override {
    const double phase = 0.01 * n_++;
    const VecX angles =
        (VecX(6) << 0.4 + 0.14 * std::sin(phase), 0.5 + 0.16 * std::sin(phase + 0.3),
         0.4 + 0.1 * std::sin(2 * phase), 0.6 + 0.1 * std::cos(phase), 0.35, 0.45)
            .finished();
    const Kinematics& map = *pipeline.config().kinematics;
    VecX at = angles.head(map.space().n_x());
    EXPECT_EQ(map.inverse(at, input.device.sample.q), InverseStatus::kExact);
    EXPECT_EQ(map.position(input.device.sample.q, at), MapStatus::kOk);
    proxy.x = at;
    if (proxy.mode == ProxyMode::kHeld) {
      proxy.x[0] = std::min(at[0], 0.35);
      proxy.x[1] = std::min(at[1], 0.45);
      return;
    }
    proxy.planes.normals = MatXQ::Zero(at.size(), 2);
    proxy.planes.normals(0, 0) = proxy.planes.normals(1, 1) = 1.0;
    proxy.planes.offsets = joints(0.35, 0.45);
  }

  int n_{0};
};

TEST(IdleFinger, ActiveFingerGetsTheSameBits) {
  for (const RendererKind renderer : kEveryRenderer) {
    for (const ProxyMode mode : {ProxyMode::kHeld, ProxyMode::kPlanes}) {
      for (const bool guard : {false, true}) {
        SCOPED_TRACE(std::string(name(renderer)) + (guard ? " guarded" : ""));
        Hand hand(3, renderer, mode, guard), alone(1, renderer, mode, guard);
        hand.engage();
        alone.engage();
        double most = 0.0;
        for (int i = 0; i < 700; ++i) {
          const TickRecord both = hand.tick(), one = alone.tick();
          ASSERT_EQ(both.life.state, LifecycleState::kEngaged);
          ASSERT_EQ(both.effort.tau_a[0], one.effort.tau_a[0]) << i;
          ASSERT_EQ(both.effort.q_star[0], one.effort.q_star[0]);
          for (const int idle : {1, 2}) ASSERT_NEAR(both.effort.tau_elastic[idle], 0.0, 1e-10);
          ASSERT_EQ(VecX(both.anchor.x.head(2)), one.anchor.x);
          ASSERT_EQ(both.anchor.free, mode == ProxyMode::kPlanes ? 0b110u : 0u);
          most = std::max(most, std::abs(one.effort.tau_elastic[0]));
        }
        EXPECT_GT(most, 1.0) << "the stops were felt";
      }
    }
  }
}

}  // namespace
}  // namespace haptic::core
