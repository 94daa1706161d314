// Which device may pace the loop.
#include <gtest/gtest.h>

#include "tests/server/scene/scene_text.hpp"
#include "tests/server/support/scripted_device.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

const std::string kLoop = "loop { paced_by: \"finger\" }\n";
const std::string kBoard =
    replaced(kFinger, "simulated_finger {}", "board { port: \"/dev/none\" max_effort: 40 }");

TEST(PacingScene, TheTimerPacesWhereNobodyIsNamed) {
  EXPECT_EQ(parse(kBoard).loop.paced_by, "");
  EXPECT_EQ(parse(kBoard).resolved.find("paced_by"), std::string::npos);
}

TEST(PacingScene, ABoardPacesByItsName) {
  const server::Scene scene = parse(kBoard + kLoop);
  EXPECT_EQ(scene.loop.paced_by, "finger");
  EXPECT_NE(scene.resolved.find("paced_by: \"finger\""), std::string::npos);
  EXPECT_EQ(parse(kBoard, {"loop.paced_by=finger"}).loop.paced_by, "finger");
}

TEST(PacingScene, WhatHasNoClockOfItsOwnDoesNotPace) {
  EXPECT_NE(error_of(kFinger + kLoop)
                .find("loop.paced_by = \"finger\": must be a board: simulated and replayed devices "
                      "have no clock of their own"),
            std::string::npos)
      << error_of(kFinger + kLoop);
  const std::string replayed =
      replaced(kFinger, "simulated_finger {}",
               "replay { file: \"motion/reach_and_grasp.csv\" max_effort: 40 }");
  EXPECT_NE(error_of(replayed + kLoop).find("must be a board"), std::string::npos)
      << error_of(replayed + kLoop);
}

TEST(PacingScene, AnUnknownNameIsToldWhichBoardsThereAre) {
  for (const char* name : {"fingers", "", "Finger"}) {
    const std::string text = kBoard + "loop { paced_by: \"" + name + "\" }\n";
    EXPECT_NE(error_of(text).find("loop.paced_by = \"" + std::string(name) +
                                  "\": must be the name of a board: \"finger\""),
              std::string::npos)
        << error_of(text);
  }
  EXPECT_NE(
      error_of(kFinger, {"loop.paced_by=thumb"}).find("must be absent: the scene has no board"),
      std::string::npos);
}

TEST(PacingScene, OneDevicePacesAtMost) {
  EXPECT_NE(
      error_of(kBoard + "loop { paced_by: \"finger\" paced_by: \"thumb\" }\n").find("paced_by"),
      std::string::npos);
  EXPECT_NE(error_of(kBoard + "loop { paced_by: [\"finger\", \"thumb\"] }\n"), "no error");
}

/// A device that tells of its samples.
class Telling final : public hw::Device {
 public:
  explicit Telling(core::Duration period) { info_.limits.sample_period = period; }
  [[nodiscard]] const hw::DeviceInfo& info() const noexcept override { return info_; }
  void read(core::TimePoint, core::DeviceReading&) noexcept override {}
  void write(core::TimePoint, const hw::Command&) noexcept override {}
  void close() noexcept override {}
  [[nodiscard]] hw::SampleSignal* sample_signal() noexcept override { return &signal_; }

 private:
  hw::DeviceInfo info_{};
  hw::SampleSignal signal_{};
};

std::string refusal(hw::Device& device) {
  server::LoopScene loop;
  loop.paced_by = "finger";
  try {
    server::check_pacing(loop, device);
  } catch (const core::DeviceError& error) {
    return error.what();
  }
  return "none";
}

TEST(PacingScene, OnlyABoardOfTheLoopsPeriodPacesIt) {
  Telling same(1ms), half(2ms), close(1001us);
  EXPECT_EQ(refusal(same), "none");
  EXPECT_EQ(
      refusal(half),
      "loop.paced_by = \"finger\": this board takes a sample every 2 ms; must be loop.period, "
      "1 ms");
  EXPECT_NE(refusal(close), "none");
  ScriptedDevice without_a_clock;
  EXPECT_NE(refusal(without_a_clock).find("has no clock of its own; must be a board"),
            std::string::npos);
}

}  // namespace
}  // namespace haptic::test
