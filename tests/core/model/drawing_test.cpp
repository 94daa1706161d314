#include "haptic/core/model/drawing.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <set>

#include "haptic/core/model/linear.hpp"
#include "haptic/core/model/serial_chain.hpp"
#include "haptic/core/model/stylus.hpp"
#include "tests/core/model/drawn_frames.hpp"
#include "tests/core/model/sample_hands.hpp"

namespace haptic::core {
namespace {

using Eigen::Vector3d;

constexpr double kClose = 1e-9;  // m, or 1
constexpr DrawnPart kDevice = DrawnPart::kDevice, kTool = DrawnPart::kTool;

ChainJoint joint(const char* name, JointKind kind, const char* parent, Pose3 origin, Point3 axis) {
  return {name, kind, true, parent, origin, axis, -0.4, 0.9};
}

/// Two branches on a palm that turns and slides, of joints in every direction.
SerialChainParameters branched() {
  SerialChainParameters chain;
  chain.palm = TrackedPalm{};
  chain.joints = {
      joint("root", JointKind::kRevolute, "base", {{0.1, 0.0, 0.02}, {0.1, 0.2, 0.3, 0.9}},
            {1.0, 2.0, 0.5}),
      joint("left", JointKind::kPrismatic, "root", {{0.0, 0.05, 0.0}, {}}, {0.0, 1.0, -1.0}),
      joint("right", JointKind::kRevolute, "root", {{0.02, -0.05, 0.0}, {0.5, 0.0, 0.0, 0.5}},
            {0.0, 0.0, 2.0})};
  chain.joints[0].actuated = false;
  chain.outputs = {{"left_tip", "left", OutputKind::kPoint, {{0.03, 0.01, 0.0}, {}}},
                   {"right_tip", "right", OutputKind::kFrame, {{0.04, 0.0, 0.01}, {0, 1, 0, 1}}}};
  return chain;
}

LinearMap plate() {
  LinearMap map;
  map.dofs = {{"u", Unit::kMetre, true, -0.05, 0.05}, {"v", Unit::kMetre, false, -0.05, 0.05}};
  map.coordinates = {{"x", Unit::kMetre}, {"y", Unit::kMetre}, {"z", Unit::kMetre}};
  map.A = Eigen::Matrix<double, 3, 2>{{1.0, 0.3}, {-0.2, 0.9}, {0.4, 0.1}};
  map.x_0 = Vector3d(0.1, 0.0, -0.2);
  return map;
}

/// A length and an angle, which are no axes of one space.
LinearMap crank() {
  LinearMap map = plate();
  map.coordinates = {{"x", Unit::kMetre}, {"angle", Unit::kRadian, CoordinateKind::kAngle}};
  map.A = Eigen::Matrix2d{{1.0, 0.01}, {-2.0, 1.0}};
  map.x_0 = Eigen::Vector2d(0.1, 0.4);
  return map;
}

struct Drawn {
  const char* name;
  std::unique_ptr<Kinematics> map;
};

/// One of every kind.
const std::vector<Drawn>& all() {
  static const std::vector<Drawn> maps = [] {
    std::vector<Drawn> made;
    made.push_back({"finger", make_finger_exoskeleton({})});
    made.push_back({"sign change", make_finger_exoskeleton(finger_sign_change())});
    made.push_back({"hand", make_hand_exoskeleton(five_fingers())});
    made.push_back({"tracked hand", make_tracked_hand(five_fingers_on_a_palm())});
    made.push_back({"stylus", make_stylus({})});
    made.push_back({"branched", make_serial_chain(branched())});
    made.push_back({"plate", make_linear(plate())});
    made.push_back({"crank", make_linear(crank())});
    return made;
  }();
  return maps;
}

/// Calls check(q, x, J) at poses all over the workspace.
template <typename Check>
void everywhere(const Kinematics& map, Check check) {
  VecX x;
  MatXQ J;
  int closed = 0;
  for (int i = 0; i < 400; ++i) {
    const VecQ q = workspace_sample(map, i);
    if (map.evaluate(q, x, J) != MapStatus::kOk) continue;
    ++closed;
    check(q, x, J);
  }
  EXPECT_GT(closed, 20);
}

/// Both at one place, and turned alike.
void expect_same(const DrawnFrame& a, const DrawnFrame& b, const std::string& what) {
  EXPECT_TRUE(a.isApprox(b, kClose)) << what << '\n' << a.matrix() << '\n' << b.matrix();
}

/// Device and finger of a drawing at poses of the finger's map: what touches stays together.
void expect_on_the_finger(const Drawing& drawing, const std::string& finger,
                          const FingerDimensions& d, const std::vector<DrawnFrame>& frames) {
  const auto device = [&](const char* n) {
    return frames[body_named(drawing, finger + n, kDevice)];
  };
  const auto tool = [&](const char* n) { return frames[body_named(drawing, finger + n, kTool)]; };
  expect_same(device("guide_1"), tool("proximal"), finger + "guide_1");
  expect_same(device("guide_2"), tool("middle"), finger + "guide_2");
  const Vector3d foot1 = tool("proximal").inverse() * (device("rod_1") * Vector3d(0, d.rod1, 0));
  const Vector3d foot2 = tool("middle").inverse() * (device("rod_2") * Vector3d(0, d.rod2, 0));
  for (const Vector3d& foot : {foot1, foot2}) {
    EXPECT_NEAR(foot.y(), 0.0, kClose) << finger;
    EXPECT_NEAR(foot.z(), 0.0, kClose) << finger;
    EXPECT_GT(foot.x(), 0.0) << finger;
  }
}

TEST(Drawing, LinkageSitsOnThePhalanges) {
  const auto alone = make_finger_exoskeleton({});
  const auto hand = make_hand_exoskeleton(five_fingers());
  const std::pair<const Kinematics*, std::vector<HandFinger>> maps[] = {
      {alone.get(), {{"", {}}}}, {hand.get(), five_fingers()}};
  for (const auto& [map, fingers] : maps) {
    const Drawing drawing = map->drawing();
    everywhere(*map, [&, fingers = fingers](const VecQ& q, const VecX& x, const MatXQ&) {
      const auto frames = drawn_frames(drawing, q, x);
      for (const HandFinger& finger : fingers) {
        const std::string prefix = finger.name.empty() ? "" : finger.name + ".";
        expect_on_the_finger(drawing, prefix, finger.dimensions, frames);
      }
    });
  }
}

/// An output, and the body of the device that it is on.
struct DrawnOutput {
  std::string name{}, body{};
  OutputKind kind{};
  Pose3 offset{};
};

void expect_bodies_at_outputs(const Kinematics& map, const std::vector<DrawnOutput>& outputs) {
  const Drawing drawing = map.drawing();
  everywhere(map, [&](const VecQ& q, const VecX& x, const MatXQ&) {
    const auto frames = drawn_frames(drawing, q, x);
    for (const DrawnOutput& output : outputs) {
      const Point3& p = output.offset.position;
      const UnitQuaternion& r = output.offset.orientation;
      DrawnFrame at = frames[body_named(drawing, output.body, kDevice)];
      at.translate(Vector3d(p.x, p.y, p.z));
      at.rotate(Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized());
      const DrawnFrame& tool = frames[body_named(drawing, output.name, kTool)];
      EXPECT_TRUE(at.translation().isApprox(tool.translation(), kClose)) << output.name;
      if (output.kind == OutputKind::kFrame) expect_same(at, tool, output.name);
    }
  });
}

TEST(Drawing, DevicesReachTheirOutputs) {
  std::vector<DrawnOutput> outputs;
  for (const ChainOutput& o : branched().outputs) {
    outputs.push_back({o.name, o.link, o.kind, o.offset});
  }
  expect_bodies_at_outputs(*make_serial_chain(branched()), outputs);
  expect_bodies_at_outputs(*make_stylus({}),
                           {{"tip", "gimbal_roll", OutputKind::kFrame, {{0.03, 0.0, 0.0}, {}}}});
  const auto hand = five_fingers_on_a_palm(OutputKind::kFrame);
  outputs.clear();
  for (const PhalanxOutput& o : hand.outputs) {
    const char* guide = o.phalanx == Phalanx::kMiddle ? ".guide_2" : ".guide_1";
    outputs.push_back({o.name, o.finger.empty() ? "palm" : o.finger + guide, o.kind, o.offset});
  }
  expect_bodies_at_outputs(*make_tracked_hand(hand), outputs);
}

TEST(Drawing, LinearDeviceMeetsItsTool) {
  const auto space = make_linear(plate()), lanes = make_linear(crank());
  const Drawing gantry = space->drawing(), lane = lanes->drawing();
  everywhere(*space, [&](const VecQ& q, const VecX& x, const MatXQ&) {
    const auto frames = drawn_frames(gantry, q, x);
    expect_same(frames[body_named(gantry, "v", kDevice)], frames[body_named(gantry, "tool", kTool)],
                "gantry");
  });
  everywhere(*lanes, [&](const VecQ& q, const VecX& x, const MatXQ&) {
    const auto frames = drawn_frames(lane, q, x);
    for (const char* name : {"x", "angle"}) {
      expect_same(frames[body_named(lane, name, kDevice)], frames[body_named(lane, name, kTool)],
                  name);
    }
  });
}

/// When a force's DoF rises, its point moves along the force's axis, or its body turns about it.
TEST(Drawing, ForcesActAlongTheirDofs) {
  for (const auto& [name, map] : all()) {
    const Drawing drawing = map->drawing();
    std::set<int> actuators;
    for (const DrawnForce& force : drawing.forces) actuators.insert(force.actuator);
    EXPECT_EQ(static_cast<int>(actuators.size()), map->layout().n_a()) << name;
    everywhere(*map, [&, name = name, &map = map](const VecQ& q, const VecX& x, const MatXQ&) {
      const auto before = drawn_frames(drawing, q, x);
      for (const DrawnForce& force : drawing.forces) {
        VecQ risen = q;
        risen[map->layout().actuated(force.actuator)] += 1e-6;
        const auto body = static_cast<std::size_t>(force.body);
        const DrawnFrame &from = before[body], to = drawn_frames(drawing, risen, x)[body];
        const Eigen::AngleAxisd turn(from.linear().transpose() * to.linear());
        const Vector3d way =
            force.torque
                ? Vector3d(turn.axis() * turn.angle())
                : Vector3d(from.linear().transpose() * (to * force.point - from * force.point));
        ASSERT_GT(way.norm(), 1e-9) << name;
        const Vector3d slip = to * force.point - from * force.point;
        EXPECT_TRUE(!force.torque || slip.norm() < kClose) << name;
        EXPECT_TRUE(way.normalized().isApprox(force.axis, 1e-4)) << name << " " << way.transpose();
      }
    });
  }
}

TEST(Drawing, IsATreeOfUnitAxes) {
  for (const auto& [name, map] : all()) {
    const Drawing drawing = map->drawing();
    std::set<std::pair<DrawnPart, std::string>> names;
    for (int b = 0; b < static_cast<int>(drawing.bodies.size()); ++b) {
      const DrawnBody& body = drawing.bodies[static_cast<std::size_t>(b)];
      EXPECT_TRUE(names.insert({body.part, body.name}).second) << name << " " << body.name;
      EXPECT_LT(body.parent, b) << name;
      EXPECT_NEAR(body.orientation.norm(), 1.0, 1e-12) << name;
      if (body.parent >= 0) {
        EXPECT_EQ(body.part, drawing.bodies[static_cast<std::size_t>(body.parent)].part) << name;
      }
      for (const DrawnMotion& motion : body.motions) {
        EXPECT_NEAR(motion.axis.norm(), 1.0, 1e-12) << name;
        EXPECT_LT(motion.target, b) << name;
        EXPECT_EQ(motion.value, body.part == kTool ? DrawnValue::kX : DrawnValue::kQ) << name;
      }
      for (const DrawnCapsule& capsule : body.capsules) EXPECT_GT(capsule.radius, 0.0) << name;
    }
  }
}

TEST(Drawing, ManyCoordinatesHaveNone) {
  LinearMap map = plate();
  map.coordinates.clear();
  for (int j = 0; j < 9; ++j) map.coordinates.push_back({"x" + std::to_string(j), Unit::kMetre});
  map.A = MatXQ::Ones(9, 2);
  map.x_0 = {};
  EXPECT_TRUE(make_linear(map)->drawing().bodies.empty());
}

}  // namespace
}  // namespace haptic::core
