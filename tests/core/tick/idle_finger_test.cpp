// Idle fingers of a hand in which another one presses
// (core/METHOD.md#model-only-what-a-scene-needs).
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "haptic/core/error.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "tests/core/tick/finger_bench.hpp"
#include "tests/support/pressing_hand.hpp"

namespace haptic::core {
namespace {

using namespace test;

/// Some equal fingers in virtual time: the first presses on stops and moves, the second moves
/// freely, the third rests. The proxy is what a client on this machine would send, held or as
/// planes.
class Hand : public DrivenPipeline {
 public:
  Hand(int fingers, RendererKind renderer, ProxyMode mode, bool guard = false)
      : DrivenPipeline(config(equal_fingers(fingers), renderer, guard)) {
    input.proxy.mode = mode;
  }
  [[nodiscard]] const Kinematics& map() const { return *pipeline.config().kinematics; }
  [[nodiscard]] VecX f_of(const VecQ& q) const {
    VecX x;
    EXPECT_EQ(map().position(q, x), MapStatus::kOk);
    return x;
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
    EXPECT_EQ(map().inverse(angles.head(map().space().n_x()), input.device.sample.q),
              InverseStatus::kExact);
    const VecX at = f_of(input.device.sample.q);
    ProxySnapshot& p = input.proxy;
    p.x = at;
    if (p.mode == ProxyMode::kHeld) {
      p.x[0] = std::min(at[0], 0.35);
      p.x[1] = std::min(at[1], 0.45);
      return;
    }
    p.planes.normals = MatXQ::Zero(at.size(), 2);
    p.planes.normals(0, 0) = p.planes.normals(1, 1) = 1.0;
    p.planes.offsets = joints(0.35, 0.45);
  }

  int n_{0};
};

TEST(IdleFinger, ActiveFingerGetsTheSameBits) {
  for (const RendererKind renderer : kAllRenderers) {
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
          ASSERT_EQ(VecX(both.anchor.x.head(2)), one.anchor.x);
          ASSERT_EQ(both.anchor.free, mode == ProxyMode::kPlanes ? 0b110u : 0u);
          most = std::max(most, std::abs(one.effort.tau_elastic[0]));
        }
        EXPECT_GT(most, 1.0) << "the stops were felt";
      }
    }
  }
}

TEST(IdleFinger, IsReportedAndNeverPulled) {
  for (const RendererKind renderer : kAllRenderers) {
    for (const ProxyMode mode : {ProxyMode::kHeld, ProxyMode::kPlanes}) {
      SCOPED_TRACE(std::string(name(renderer)));
      Hand hand(3, renderer, mode);
      hand.engage();
      for (int i = 0; i < 700; ++i) {
        const TickRecord record = hand.tick();
        ASSERT_EQ(record.anchor.x_probe, hand.f_of(record.sensed.q));
        for (int k = 2; k < 6; ++k) ASSERT_EQ(record.anchor.x[k], record.anchor.x_probe[k]);
        for (const int finger : {1, 2}) ASSERT_NEAR(record.effort.tau_elastic[finger], 0.0, 1e-10);
        ASSERT_NEAR((record.effort.q_star - record.sensed.q).tail(4).norm(), 0.0, 1e-13);
      }
    }
  }
}

TEST(IdleFinger, FreeModeTellsTheStateToo) {
  Hand hand(3, RendererKind::kSubspaceLinear, ProxyMode::kFree);
  for (int i = 0; i < 100; ++i) {
    const TickRecord record = hand.tick();
    ASSERT_EQ(record.anchor.free, 0b111u);
    ASSERT_EQ(record.anchor.x_probe, hand.f_of(record.sensed.q));
    ASSERT_EQ(record.anchor.x, record.anchor.x_probe);
  }
}

/// core/METHOD.md#hand-without-prior: what the scene loader refuses, the pipeline refuses by
/// itself.
TEST(PipelineConfig, UndeterminedMapNeedsAPrior) {
  PipelineConfig c = config_of(RendererKind::kSubspaceLinear);
  c.kinematics = make_hand_exoskeleton({{"one", finger_sign_change()}});
  EXPECT_NO_THROW(Pipeline{c});
  TrackedHandParameters hand;
  hand.fingers.push_back(MountedFinger{HandFinger{"one", finger_sign_change()}, Pose3{}});
  hand.outputs.push_back(PhalanxOutput{"tip", "one", Phalanx::kMiddle, OutputKind::kPoint,
                                       Pose3{{0.03, 0.0, 0.0}, {}}});
  c.kinematics = make_tracked_hand(hand);  // eight DoFs, three coordinates
  c.device.q_lower = VecQ::Constant(8, -5.0);
  c.device.q_upper = VecQ::Constant(8, 5.0);
  try {
    Pipeline refused(c);
    ADD_FAILURE() << "not refused";
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("prior: must be given"), std::string::npos)
        << error.what();
  }
  c.projection.prior = Prior{1e-3, VecQ::Ones(7)};
  EXPECT_NO_THROW(Pipeline{c});
}

}  // namespace
}  // namespace haptic::core
