#include "server/owner/state/drawing_message.hpp"

#include <gtest/gtest.h>

#include "server/owner/state/device_message.hpp"
#include "tests/core/model/drawn_frames.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

using Doubles = google::protobuf::RepeatedField<double>;

Eigen::Vector3d point(const Doubles& values) {
  if (values.empty()) return Eigen::Vector3d::Zero();
  EXPECT_EQ(values.size(), 3);
  return Eigen::Vector3d(values.data());
}

core::DrawnMotion motion(const v1::DrawnMotion& message) {
  core::DrawnMotion motion;
  motion.kind = static_cast<core::DrawnMotion::Kind>(message.kind());
  if (!message.axis().empty()) motion.axis = point(message.axis());
  motion.value = static_cast<core::DrawnValue>(message.value());
  motion.index = static_cast<int>(message.index());
  motion.factor = message.factor();
  motion.offset = message.offset();
  motion.target = static_cast<int>(message.target());
  motion.target_point = point(message.target_point());
  return motion;
}

/// The drawing that a client makes of it.
core::Drawing read(const v1::Drawing& message) {
  core::Drawing drawing;
  for (const v1::DrawnBody& from : message.bodies()) {
    core::DrawnBody body{from.name(), static_cast<core::DrawnPart>(from.part()), from.parent()};
    body.position = point(from.position());
    if (!from.orientation().empty()) {
      body.orientation.coeffs() = Eigen::Vector4d(from.orientation().data());
    }
    for (const auto& entry : from.motions()) body.motions.push_back(motion(entry));
    for (const auto& shape : from.capsules()) {
      body.capsules.push_back({point(shape.from()), point(shape.to()), shape.radius()});
    }
    drawing.bodies.push_back(body);
  }
  for (const v1::DrawnForce& from : message.forces()) {
    drawing.forces.push_back({static_cast<int>(from.actuator()), static_cast<int>(from.body()),
                              point(from.point()), point(from.axis()), from.torque()});
  }
  return drawing;
}

void expect_same_shapes(const core::DrawnBody& a, const core::DrawnBody& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.part, b.part);
  ASSERT_EQ(a.capsules.size(), b.capsules.size()) << a.name;
  for (std::size_t i = 0; i < a.capsules.size(); ++i) {
    EXPECT_EQ(a.capsules[i].from, b.capsules[i].from) << a.name;
    EXPECT_EQ(a.capsules[i].to, b.capsules[i].to) << a.name;
    EXPECT_EQ(a.capsules[i].radius, b.capsules[i].radius) << a.name;
  }
}

TEST(DrawingMessage, MovesLikeTheModel) {
  const auto map = make_tracked_hand(five_fingers_on_a_palm(core::OutputKind::kFrame));
  const core::Drawing sent = map->drawing();
  const core::Drawing received = read(server::to_message(sent));
  ASSERT_EQ(sent.bodies.size(), received.bodies.size());
  for (std::size_t b = 0; b < sent.bodies.size(); ++b) {
    expect_same_shapes(sent.bodies[b], received.bodies[b]);
  }
  ASSERT_EQ(sent.forces.size(), received.forces.size());
  for (std::size_t i = 0; i < sent.forces.size(); ++i) {
    EXPECT_EQ(sent.forces[i].actuator, received.forces[i].actuator);
    EXPECT_EQ(sent.forces[i].body, received.forces[i].body);
    EXPECT_EQ(sent.forces[i].axis, received.forces[i].axis);
    EXPECT_EQ(sent.forces[i].torque, received.forces[i].torque);
  }
  core::VecX x;
  core::MatXQ J;
  for (int i = 0; i < 200; ++i) {
    const core::VecQ q = core::workspace_sample(*map, i);
    if (map->evaluate(q, x, J) != core::MapStatus::kOk) continue;
    const auto expected = drawn_frames(sent, q, x), got = drawn_frames(received, q, x);
    for (std::size_t b = 0; b < got.size(); ++b) {
      EXPECT_EQ(got[b].matrix(), expected[b].matrix()) << sent.bodies[b].name;
    }
  }
}

/// A message of the WebSocket may have 64 KB, so that a device's picture is a part of one.
constexpr std::size_t kMost = 32 * 1024;

TEST(DrawingMessage, EveryShippedDeviceHasOne) {
  std::size_t drawn = 0;
  for (const std::string& name : shipped_names()) {
    SCOPED_TRACE(name);
    for (const server::DeviceScene& device : shipped_scene(name).devices) {
      const v1::Device message = server::describe(device.name, {}, device.pipeline);
      EXPECT_GE(message.drawing().bodies_size(), 2);
      EXPECT_GE(message.drawing().forces_size(), 1);
      EXPECT_LT(message.ByteSizeLong(), kMost);
      ++drawn;
    }
  }
  EXPECT_GE(drawn, 15u);
}

TEST(DrawingMessage, AMapWithoutOneSaysSo) {
  std::string coordinates, rows;
  for (int i = 0; i < 9; ++i) {
    coordinates += "    coordinate { name: \"x" + std::to_string(i) + "\" unit: \"m\" }\n";
    rows += i > 0 ? ", 1, 0.5" : "1, 0.5";
  }
  const std::string scene =
      replaced(replaced(kLinear, "    coordinate { name: \"x\" unit: \"m\" }\n", coordinates),
               "A: [1, 0.5]", "A: [" + rows + "]");
  const server::Scene parsed = parse(scene);
  EXPECT_FALSE(server::describe("d", {}, parsed.devices[0].pipeline).has_drawing());
}

}  // namespace
}  // namespace haptic::test
