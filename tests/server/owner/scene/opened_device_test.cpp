// Facts that a scene takes for granted of its devices: force control, and a clock that paces the
// loop.
#include <array>
#include <cmath>

#include "tests/server/owner/scene/scene_text.hpp"
#include "tests/server/support/scripted_device.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;
using server::ForceControlPlace;

/// The finger on a board, with force control.
std::string controlled(const std::string& force_control) {
  return with_option(kBoard, "force_control { " + force_control + " }");
}
const std::string kServer = "server { proportional: 2 integral_per_s: 30 ";
const std::string kAdmittance = "admittance { damping_n_s_per_m: 400 max_rate_m_per_s: 0.03 ";

TEST(ForceControlScene, AbsentMeansAny) {
  const auto device = parse(kBoard).devices[0];
  EXPECT_EQ(device.force_control, ForceControlPlace::kAny);
  EXPECT_FALSE(device.pipeline.force_control.enabled());
}

TEST(ForceControlScene, OneServerLoopPerActuator) {
  const server::Scene scene = parse(controlled(kServer + "friction_n: 12 }"));
  const server::DeviceScene& device = scene.devices[0];
  EXPECT_EQ(device.force_control, ForceControlPlace::kServer);
  ASSERT_EQ(device.pipeline.force_control.loops.size(), 1u);
  const core::ForceLoopGains& gains = device.pipeline.force_control.loops[0];
  EXPECT_EQ(gains.proportional, 2.0);
  EXPECT_EQ(gains.integral, 30.0);
  EXPECT_EQ(gains.friction, 12.0);
  EXPECT_EQ(gains.friction_band, 1.0);
  EXPECT_EQ(gains.output_limit, 32.0) << "force_n and the friction";
  expect_resolved(scene, "output_limit_n: [32]");
  const server::Scene most = parse(controlled(kServer + "friction_n: 31 }"));
  EXPECT_EQ(most.devices[0].pipeline.force_control.loops.at(0).output_limit, 40.0);
}

TEST(ForceControlScene, LoadCellsAreWatchedByDefault) {
  const server::Scene scene = parse(controlled(kServer + "friction_n: 12 }"));
  ASSERT_EQ(scene.devices[0].pipeline.force_control.cells.size(), 1u);
  const core::CellRatings& cell = scene.devices[0].pipeline.force_control.cells[0];
  EXPECT_EQ(cell.range, 80.0) << "max_effort, and what friction holds";
  EXPECT_EQ(cell.rate, 4000.0) << "max_effort in 10 ms";
  EXPECT_EQ(cell.swing, 4.0);
  EXPECT_EQ(cell.friction, 34.0) << "2 friction_n and a quarter of max_effort";
  EXPECT_FALSE(cell.damping) << "the board's";
  for (const char* field : {"cell_range_n: [80]", "cell_rate_n_per_s: [4000]", "stuck_n: [4]",
                            "drive_friction_n: [34]"}) {
    expect_resolved(scene, field);
  }
  const auto given =
      parse(controlled(kServer + "cell_range_n: 50 cell_rate_n_per_s: 900 stuck_n: 3 "
                                 "drive_friction_n: 7 drive_damping_n_s_per_m: 0 }"));
  const core::CellRatings& told = given.devices[0].pipeline.force_control.cells.at(0);
  EXPECT_EQ((std::array{told.range, told.rate, told.swing, told.friction}),
            (std::array{50.0, 900.0, 3.0, 7.0}));
  EXPECT_EQ(told.damping, 0.0);
}

TEST(ForceControlScene, AnAdmittanceTakesTheDofsTravel) {
  const auto device = parse(controlled(kAdmittance + "cell_range_n: 60 }")).devices[0];
  EXPECT_EQ(device.force_control, ForceControlPlace::kAdmittance);
  ASSERT_EQ(device.pipeline.force_control.admittances.size(), 1u);
  const core::AdmittanceParameters& p = device.pipeline.force_control.admittances[0];
  EXPECT_EQ(p.mass, 0.0);
  EXPECT_EQ(p.damping, 400.0);
  EXPECT_EQ(p.max_rate, 0.03);
  EXPECT_EQ(p.lower, 0.0);
  EXPECT_EQ(p.upper, 0.0335);
  const core::CellRatings& cell = device.pipeline.force_control.cells.at(0);
  EXPECT_EQ(cell.range, 60.0);
  EXPECT_EQ(cell.rate, 4000.0);
  EXPECT_DOUBLE_EQ(cell.swing, 0.00335) << "a tenth of the travel";
  EXPECT_TRUE(std::isinf(cell.friction)) << "the drive's force is not known";
}

TEST(ForceControlScene, ErrorsNamePlaceValueAndRule) {
  const std::string path = "device[0].force_control";
  const std::string server = controlled(kServer + "}"), admittance = controlled(kAdmittance + "}");
  expect_each_value_says({
      {server, path + ".server.output_limit_n[0]=41",
       "must be at most what the device can give, 40"},
      {server, path + ".server.cell_range_n[0]=0", "must be > 0"},
      {server, path + ".server.drive_friction_n=[1, 2]", "must have one value per actuated DoF, 1"},
      {server, path + ".server.drive_damping_n_s_per_m[0]=-1", "must be >= 0"},
      {admittance, path + ".admittance.stuck_m[0]=-1", "must be > 0"},
      {admittance, path + ".admittance.upper[0]=0.06", "must be at most the DoF's own, 0.0335"},
  });
  expect_each_says({
      {"nothing", controlled(""), path + ".where: is required"},
      {"a gain", controlled("server { integral_per_s: 30 }"), path + ".server.proportional"},
      {"simulated", with_option(kFinger, "force_control { board {} }"),
       "must go with board: nothing else measures its force"},
  });
}

TEST(ForceControlScene, AnIncapableDeviceIsRefused) {
  struct Case {
    ForceControlPlace place;
    bool measures, takes_positions, closes_loop;
    const char* says;
  };
  for (const Case& c :
       {Case{ForceControlPlace::kAny, false, false, false, "no error"},
        Case{ForceControlPlace::kBoard, false, false, false, "does not close the loop"},
        Case{ForceControlPlace::kBoard, true, true, true, "no error"},
        Case{ForceControlPlace::kServer, false, false, false, "measures no force"},
        Case{ForceControlPlace::kServer, true, false, false, "no error"},
        Case{ForceControlPlace::kServer, true, true, true, "two loops in a row fight"},
        Case{ForceControlPlace::kAdmittance, false, true, false, "measures no force"},
        Case{ForceControlPlace::kAdmittance, true, false, false, "positions"},
        Case{ForceControlPlace::kAdmittance, true, true, false, "no error"}}) {
    hw::DeviceInfo info;
    info.measures_force = c.measures;
    info.takes_positions = c.takes_positions;
    info.closes_force_loop = c.closes_loop;
    const std::string said =
        message_of<core::DeviceError>([&] { server::check_force_control(c.place, info); });
    EXPECT_NE(said.find(c.says), std::string::npos) << said << "\nwanted: " << c.says;
  }
}

TEST(PacingScene, ABoardPacesByItsName) {
  EXPECT_EQ(parse(kBoard).loop.paced_by, "") << "the timer";
  EXPECT_EQ(parse(kBoard).resolved.find("paced_by"), std::string::npos);
  const server::Scene scene = parse(kBoard + "loop { paced_by: \"finger\" }\n");
  EXPECT_EQ(scene.loop.paced_by, "finger");
  expect_resolved(scene, "paced_by: \"finger\"");
  EXPECT_EQ(parse(kBoard, {"loop.paced_by=finger"}).loop.paced_by, "finger");
}

TEST(PacingScene, ErrorsNameTheBoardsThereAre) {
  for (const std::string& text : {kFinger, kReplayed}) {
    expect_says(text,
                "loop.paced_by = \"finger\": must be absent: no device of the scene has a "
                "sample clock",
                {"loop.paced_by=finger"});
  }
  for (const std::string name : {"fingers", "", "Finger"}) {
    expect_says(
        kBoard + "loop { paced_by: \"" + name + "\" }\n",
        "loop.paced_by = \"" + name + "\": must be a device with a sample clock: \"finger\"");
  }
  expect_says(kFinger, "must be absent: no device of the scene", {"loop.paced_by=thumb"});
  expect_says(kBoard + "loop { paced_by: \"finger\" paced_by: \"thumb\" }\n", "paced_by");
  EXPECT_NE(error_of(kBoard + "loop { paced_by: [\"finger\", \"thumb\"] }\n"), "no error");
}

/// A device with a sample signal.
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

TEST(PacingScene, TheBoardHasTheLoopsPeriod) {
  server::LoopScene loop{.paced_by = "finger"};
  const auto said = [&](hw::Device& device) {
    return message_of<core::DeviceError>([&] { server::check_pacing(loop, device); });
  };
  Telling same(1ms), half(2ms), close(1001us);
  EXPECT_EQ(said(same), "no error");
  EXPECT_EQ(said(half),
            "loop.paced_by = \"finger\": this board takes a sample every 2 ms; must be "
            "loop.period, 1 ms");
  EXPECT_NE(said(close), "no error");
  ScriptedDevice without_a_clock;
  EXPECT_NE(said(without_a_clock).find("has no clock of its own; must be a board"),
            std::string::npos);
}

}  // namespace
}  // namespace haptic::test
