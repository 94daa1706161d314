#include "hw/emulator/faults.hpp"

#include <gtest/gtest.h>

#include "haptic/core/error.hpp"

namespace haptic::hw::emulator {
namespace {

TEST(EmulatorFaults, AreReadFromTheirText) {
  const FaultSpec unplug = parse_fault("unplug@10+2.5");
  EXPECT_EQ(unplug.kind, FaultKind::kUnplug);
  EXPECT_EQ(unplug.at, 10.0);
  EXPECT_EQ(unplug.length, 2.5);
  const FaultSpec drift = parse_fault("drift@5=0.002");
  EXPECT_EQ(drift.kind, FaultKind::kDrift);
  EXPECT_EQ(drift.amount, 0.002);
  EXPECT_TRUE(drift.active(1e6));
}

TEST(EmulatorFaults, FaultsLastTheirTime) {
  const FaultSpec fault = parse_fault("stall@1+0.5");
  EXPECT_FALSE(fault.active(0.999));
  EXPECT_TRUE(fault.active(1.0));
  EXPECT_FALSE(fault.active(1.5));
}

TEST(EmulatorFaults, RefusesUnreadableText) {
  for (const char* text : {"unplug", "unplug@", "unplug@x", "melt@3", "stall@-1", "stall@1+",
                           "stall@1+2x", "drift@1=nan", ""}) {
    EXPECT_THROW(static_cast<void>(parse_fault(text)), core::DeviceError) << text;
  }
}

TEST(EmulatorFaults, NamesReadBack) {
  for (int i = 0; i < 6; ++i) {
    const auto kind = static_cast<FaultKind>(i);
    EXPECT_EQ(parse_fault(name(kind) + "@1").kind, kind);
  }
}

TEST(EmulatorFaults, FaultsFollowTheSeed) {
  const auto one = draw_faults(1, 20, 60.0), same = draw_faults(1, 20, 60.0),
             other = draw_faults(2, 20, 60.0);
  ASSERT_EQ(one.size(), 20U);
  bool differs = false;
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].at, same[i].at);
    EXPECT_LE(one[i].at, 60.0);
    differs = differs || one[i].at != other[i].at;
  }
  EXPECT_TRUE(differs);
}

}  // namespace
}  // namespace haptic::hw::emulator
