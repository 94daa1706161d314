#include "hw/board/board_device.hpp"
#include "tests/server/owner/scene/scene_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::test {
namespace {

/// A calibration file, and a scene that names it.
class CalibratedScene : public ::testing::Test {
 protected:
  void write(const std::string& text) const { file_.write(text); }
  [[nodiscard]] std::string scene() const {
    return replaced(kBoard, "max_effort: 40",
                    "max_effort: 40 calibration_file: \"" + file_.path().string() + "\"");
  }
  [[nodiscard]] hw::board::Calibration calibration() const {
    return *dynamic_cast<const hw::BoardConfig&>(*parse(scene()).devices[0].source).calibration;
  }
  TemporaryFile file_{};
};

const std::string kHead = "device_serial: \"HX-7\" date: \"2026-11-21\"\n";
const std::string kLx =
    "dof { name: \"l_x\" scale: 1.1 offset: -0.002 lower: 0.001 upper: 0.032 }\n";
const std::string kQb = "dof { name: \"q_B\" scale: -0.9 offset: 0.1 lower: -1.2 upper: 0.6 }\n";

TEST_F(CalibratedScene, TheOrderOfDofsIsFree) {
  write(kHead + kQb + kLx + "force_zero: 0.4\n");
  expect_resolved(parse(scene()), "calibration_file: \"" + file_.path().string());
  const hw::board::Calibration c = calibration();
  EXPECT_EQ(c.serial, "HX-7");
  EXPECT_EQ(c.date, "2026-11-21");
  EXPECT_EQ(c.scale[0], 1.1);
  EXPECT_EQ(c.offset[0], -0.002);
  EXPECT_EQ(c.scale[1], -0.9);
  EXPECT_EQ(c.upper[1], 0.6);
  EXPECT_EQ(c.force_zero[0], 0.4);
}

TEST_F(CalibratedScene, AdmittancesKeepTheCalibratedTravel) {
  write(kHead + kLx + kQb);
  const auto with = [&](const std::string& more) {
    return replaced(scene(), "limits {",
                    "force_control { admittance { damping_n_s_per_m: 400 max_rate_m_per_s: 0.03 " +
                        more + "} }\n  limits {");
  };
  const auto control = parse(with("")).devices[0].pipeline.force_control;
  ASSERT_EQ(control.admittances.size(), 1u);
  EXPECT_EQ(control.admittances[0].lower, 0.001);
  EXPECT_EQ(control.admittances[0].upper, 0.032);
  const std::string field = "device[0].force_control.admittance.";
  expect_says(with("lower: 0 "),
              field + "lower[0] = 0: must be at least the calibrated travel's, 0.001");
  expect_says(with("upper: 0.05 "),
              field + "upper[0] = 0.05: must be at most the calibrated travel's, 0.032");
}

TEST_F(CalibratedScene, NamesTheWrongField) {
  struct Case {
    std::string text, error;
  };
  const Case cases[] = {
      {"date: \"2026-11-21\"\n" + kLx + kQb, "device_serial: is required"},
      {"device_serial: \"HX-7\" date: \"yesterday\"\n" + kLx + kQb, "must be YYYY-MM-DD"},
      {kHead + kLx, "lacks DoF 'q_B'"},
      {kHead + kLx + kLx, "has DoF 'l_x' twice"},
      {kHead + kLx + kQb + replaced(kLx, "l_x", "l_y"), "has 3 DoFs; must have 2"},
      {kHead + "dof { nmae: \"l_x\" }", "must be a file of hapticctl calibrate"},
  };
  for (const Case& c : cases) {
    write(c.text);
    expect_says(scene(), c.error);
  }
  std::filesystem::remove(file_.path());
  expect_says(scene(), "there is none at");
}

}  // namespace
}  // namespace haptic::test
