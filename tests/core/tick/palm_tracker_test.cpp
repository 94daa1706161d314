// A palm whose pose a client says (proto/README.md#a-session, role tracker;
// proto/README.md#staleness-and-gain for its age), in virtual time. One slide of 500 N/m is carried
// by the palm: x is the sum of palm.x and the slide, and the palm's six DoFs. The proxy is kept
// behind x[0] <= 0, so that the force is -K (palm.x + slide) by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "haptic/core/error.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/tick/driven.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/pressing_hand.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using namespace std::chrono_literals;

constexpr double kPalmStiffness = 500.0;
constexpr double kPressed = 0.004;  // m: how far the palm is behind the wall

PipelineConfig config_with_tracker() {
  MatXQ A = MatXQ::Zero(7, 7);
  A(0, 0) = A(0, 6) = 1.0;
  for (int i = 0; i < 6; ++i) A(i + 1, i) = 1.0;
  LinearMap map = samples::linear_parameters(A, 0, 0.8);
  map.dofs.back() = {"slide", Unit::kMetre, true, -0.8, 0.8};
  PipelineConfig c = pressing_config(make_linear(map), RendererKind::kSubspaceLinear);
  c.device.q_lower = VecQ::Constant(7, -1.0);
  c.device.q_upper = VecQ::Constant(7, 1.0);
  c.scene.stiffness = one(kPalmStiffness);
  c.scene.damping = one(0.0);
  c.scene.slew_limit = one(1e6);
  c.tracker = TrackerSettings{0, {}};
  return c;
}

/// The device at rest, whose own palm is elsewhere; a controller and, while `tracking`, a tracker
/// that speak in every tick.
class Rig : public test::DrivenPipeline {
 public:
  Rig() : DrivenPipeline(config_with_tracker()) {
    input.device.sample.q = VecQ::Constant(7, 0.3);
    input.device.sample.q[6] = 0.0;
    proxy.mode = ProxyMode::kPlanes;
    proxy.x = VecX::Zero(7);
    proxy.planes.normals.setZero(7, 1);
    proxy.planes.normals(0, 0) = 1.0;
    proxy.planes.offsets.setZero(1);
    input.tracker.staleness = StalenessLimits{};
    input.tracker.pose = {kPressed, 0.02, 0.03, 0.1, 0.2, 0.3};
  }

  bool tracking{true};

 protected:
  void prepare() override {
    if (!tracking) return;
    ++input.tracker.seq;
    input.tracker.born = input.now;
  }
};

TEST(PalmTracker, PoseReplacesTheDevicesReading) {
  Rig rig;
  const TickRecord record = rig.run(3);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(record.sensed.q[i], rig.input.tracker.pose[static_cast<std::size_t>(i)]) << i;
  }
  EXPECT_EQ(record.sensed.q[6], 0.0);
  EXPECT_DOUBLE_EQ(record.anchor.x_probe[0], kPressed);
  EXPECT_TRUE(record.sensed.tracker.on);
  EXPECT_EQ(record.sensed.tracker.seq, 3u);
  EXPECT_EQ(record.sensed.tracker.level, Staleness::kFresh);
}

TEST(PalmTracker, WallIsFeltAtItsPose) {
  Rig rig;
  EXPECT_NEAR(rig.engage().effort.tau_a[0], -kPalmStiffness * kPressed, 1e-9);
  rig.input.tracker.pose[0] = 0.006;
  EXPECT_NEAR(rig.tick().effort.tau_a[0], -kPalmStiffness * 0.006, 1e-9);
  rig.input.tracker.pose[0] = -0.001;  // off the wall
  EXPECT_EQ(rig.tick().effort.tau_elastic[0], 0.0);
}

TEST(PalmTracker, SilenceEndsForceWithin200Ms) {
  Rig rig;
  rig.engage();
  rig.tracking = false;
  bool lost = false;
  for (int age = 1; age <= 200; ++age) {
    SCOPED_TRACE(age);
    const TickRecord record = rig.tick();
    // proto/README.md#staleness-and-gain, with the defaults: full to 100 ms, linear to 0 at 180 ms.
    const double ladder = age < 100 ? 1.0 : age < 180 ? (180.0 - age) / 80.0 : 0.0;
    EXPECT_NEAR(record.life.gain, ladder, 1e-12);
    EXPECT_NEAR(record.effort.tau_elastic[0], -ladder * kPalmStiffness * kPressed, 1e-9);
    EXPECT_EQ(record.sensed.tracker.age, age * 1ms);
    EXPECT_EQ(record.sensed.tracker.level == Staleness::kHold, age >= 20 && age < 100);
    EXPECT_EQ(record.proxy.level, Staleness::kFresh) << "the proxy's";
    lost = lost || record.life.lost;
    EXPECT_EQ(lost, age >= 180);
    EXPECT_EQ(record.life.state, age < 180 ? LifecycleState::kEngaged : LifecycleState::kArmed);
  }
  // Force never comes back by itself, and by a ramp of 200 ms where it is asked for.
  rig.tracking = true;
  EXPECT_EQ(rig.run(50).effort.tau_elastic[0], 0.0);
  ++rig.input.command.engage_id;
  EXPECT_NEAR(rig.tick().life.gain, 1.0 / 200.0, 1e-12);
}

TEST(PalmTracker, PalmIsZeroBeforeFirstPose) {
  Rig rig;
  rig.tracking = false;
  const TickRecord record = rig.run(3);
  EXPECT_EQ(record.sensed.q.head(6), VecQ::Zero(6));
  EXPECT_EQ(record.sensed.tracker.level, Staleness::kLost);
  EXPECT_EQ(record.sensed.tracker.seq, 0u);
  EXPECT_EQ(record.life.state, LifecycleState::kArmed) << "the device itself is well";
}

TEST(PalmTracker, IgnoresBadPosesAndAges) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1.1, -1.1,
                           std::numeric_limits<double>::infinity()}) {
    Rig rig;
    rig.engage();
    const std::uint64_t last = rig.input.tracker.seq;
    rig.input.tracker.pose[4] = bad;
    const TickRecord record = rig.run(30);
    EXPECT_EQ(record.sensed.q[4], 0.2);
    EXPECT_EQ(record.sensed.tracker.seq, last);
    EXPECT_EQ(record.sensed.tracker.age, 30ms);
    EXPECT_FALSE(record.faults().any());
  }
}

TEST(PalmTracker, SessionMayOnlyTightenLimits) {
  Rig rig;
  rig.input.tracker.staleness = {10ms, 40ms, 90ms};
  rig.engage();
  rig.tracking = false;
  EXPECT_EQ(rig.run(39).life.gain, 1.0);
  EXPECT_NEAR(rig.run(26).life.gain, 0.5, 1e-12);  // 65 ms: half-way from 40 to 90
}

TEST(PalmTracker, NeedsSensedDofsAndConsistentLimits) {
  const auto wrong = [](const TrackerSettings& tracker) {
    PipelineConfig config = config_with_tracker();
    config.tracker = tracker;
    return haptic::test::message_of<SceneError>([&] { return Pipeline(config); });
  };
  EXPECT_EQ(wrong({0, {}}), "no error");
  EXPECT_EQ(wrong({1, {}}), "tracker: DoF slide is actuated: must be sensed only");
  EXPECT_EQ(wrong({2, {}}), "tracker.first_dof = 2: must leave room for six of 7 DoFs");
  EXPECT_EQ(wrong({0, {20ms, 100ms, 120ms}}),
            "tracker.staleness: fade_end - hold_end must be >= 50 ms");
}

}  // namespace
}  // namespace haptic::core
