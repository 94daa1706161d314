/// A board as the loop sees it.
#include "hw/board/device_side.hpp"

#include <gtest/gtest.h>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/board/board_device.hpp"

namespace haptic::hw::board {
namespace {

DeviceSide make_side(const std::string& linkage = {}) {
  BoardConfig config;
  config.linkage = linkage;
  config.max_effort = core::VecA::Constant(1, 40.0);
  return {config, core::make_finger_exoskeleton(core::finger_sign_change()), core::Duration{0}};
}

TEST(DeviceSide, ArmedOnlyUnderTheNewestArming) {
  DeviceSide side = make_side();
  const hw::Command on{true, core::VecA::Zero(1), {}};
  core::DeviceReading reading;
  const auto armed = [&](std::uint32_t by) {
    side.read({.open = true, .armed = by}, reading);
    return reading.armed;
  };
  EXPECT_FALSE(armed(1)) << "before anyone asked";
  EXPECT_EQ(side.write(on).arming, 1u);
  EXPECT_EQ(side.write(on).arming, 1u) << "the same wish";
  EXPECT_TRUE(armed(1));
  static_cast<void>(side.write({}));
  EXPECT_FALSE(armed(1)) << "it did not hear the DISARM";
  static_cast<void>(side.write(on));
  EXPECT_FALSE(armed(1)) << "nor the second ARM";
  EXPECT_TRUE(armed(2));
}

TEST(DeviceSide, TheBoardTellsItsDrivesDamping) {
  DeviceSide side = make_side();
  side.identify({{.capabilities = HB_MEASURES_FORCE}, core::VecA::Constant(1, 3125.0)});
  EXPECT_TRUE(side.info().measures_force);
  EXPECT_EQ(side.info().limits.drive_damping, core::VecA::Constant(1, 3125.0));
}

TEST(DeviceSide, SaysWhichLinkageNoneCompared) {
  DeviceSide unnamed = make_side("finger_same_sign"), named = unnamed, own = make_side();
  unnamed.identify({{.model = "my exoskeleton"}, {}});
  ASSERT_EQ(unnamed.info().notes.size(), 1u);
  EXPECT_EQ(unnamed.info().notes[0],
            "the board does not say which linkage it carries (its model = 'my exoskeleton'); the "
            "scene has finger_same_sign");
  named.identify({{.model = "finger_same_sign"}, {}});
  own.identify({{.model = "finger_same_sign"}, {}});
  EXPECT_TRUE(named.info().notes.empty());
  EXPECT_TRUE(own.info().notes.empty()) << "the scene has dimensions without a name";
}

}  // namespace
}  // namespace haptic::hw::board
