// The tracker of a scene: which DoFs are its, its limits, and what is refused.
#include "tests/server/scene/scene_text.hpp"

namespace haptic::test {
namespace {

using std::chrono::milliseconds;

/// A slide on a palm; the tracker stands on line 8.
const std::string kOnAPalm = R"(name: "t"
device {
  name: "d"
  simulated_linear { mass: [1, 1, 1, 1, 1, 1, 1] max_effort: 5 }
  serial_chain { palm {} joint { name: "s" kind: "prismatic" actuated: true lower: 0 upper: 1 }
    output { name: "w" link: "base" point {} } output { name: "t" point { position_m: [0.1, 0, 0] } } }
  impedance { stiffness_n_per_m: 5 }
  tracker {}
  limits { force_n: 2 }
  prior { weight: 0.1 sensed_stiffness: [3, 3, 3, 3, 3, 3] }
}
)";

TEST(TrackerScene, ItsDofsAreThePalms) {
  const server::Scene scene = parse(kOnAPalm);
  const server::DeviceScene& device = scene.devices.front();
  ASSERT_TRUE(device.pipeline.tracker.has_value());
  EXPECT_EQ(device.pipeline.tracker->first_dof, 0);
  EXPECT_EQ(device.pipeline.kinematics->dofs()[0].name, "palm.x");
  EXPECT_EQ(device.pipeline.tracker->staleness.hold_end, milliseconds(100));
  EXPECT_EQ(device.pipeline.tracker->staleness.fade_end, milliseconds(180));
  EXPECT_FALSE(device.tracker_fresh_end.has_value());
  EXPECT_EQ(parse(scene.resolved).resolved, scene.resolved);
  EXPECT_FALSE(parse(replaced(kOnAPalm, "tracker {}", "")).devices[0].pipeline.tracker.has_value());
}

TEST(TrackerScene, ItsLimitsAreItsOwn) {
  const server::Scene scene = parse(replaced(
      kOnAPalm, "tracker {}",
      "tracker { fresh_end { nanos: 30000000 } hold_end { nanos: 50000000 } fade_end { nanos: "
      "110000000 } }"));
  const server::DeviceScene& device = scene.devices.front();
  EXPECT_EQ(device.tracker_fresh_end, milliseconds(30));
  EXPECT_EQ(device.pipeline.tracker->staleness.hold_end, milliseconds(50));
  EXPECT_EQ(device.pipeline.tracker->staleness.fade_end, milliseconds(110));
  EXPECT_EQ(device.pipeline.scene.staleness.hold_end, milliseconds(100)) << "the proxy's";
}

TEST(TrackerScene, WhatIsWrongIsNamedWithItsPlace) {
  EXPECT_NE(error_of(replaced(kFinger, "limits {", "tracker {}\n  limits {"))
                .find("device[0].tracker = { ... } with a device that has no tracked palm: must go "
                      "with tracked_hand, or with a serial_chain on a palm"),
            std::string::npos)
      << error_of(replaced(kFinger, "limits {", "tracker {}\n  limits {"));
  const std::string late =
      error_of(replaced(kOnAPalm, "tracker {}", "tracker { fade_end { nanos: 120000000 } }"));
  EXPECT_NE(late.find("device[0].tracker.fade_end = 120 ms: must be at least hold_end + 50 ms"),
            std::string::npos)
      << late;
}

}  // namespace
}  // namespace haptic::test
