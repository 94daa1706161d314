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
  int kind = 0;
  for (const char* name : {"stall", "brown-out", "unplug", "stuck", "drift", "hang"}) {
    EXPECT_EQ(parse_fault(name + std::string("@1")).kind, static_cast<FaultKind>(kind++));
  }
}

}  // namespace
}  // namespace haptic::hw::emulator
