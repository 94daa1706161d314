/// The recordings of people that live beside the checkout: every one of them replays, and the
/// device reports of it what a plain reader finds.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/replay/replay.hpp"
#include "hw/simulated/hand.hpp"
#include "tests/hw/virtual_loop.hpp"

namespace haptic::hw {
namespace {

struct Row {
  double time, mcp, pip;
};

/// A plain reader of its own: no code in common with the device's.
std::vector<Row> rows_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    std::istringstream text(line);
    Row row{};
    char comma = 0;
    if (text >> row.time >> comma >> row.mcp >> comma >> row.pip) rows.push_back(row);
  }
  return rows;
}

class Recordings : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    file_ = std::filesystem::path(HAPTIC_SOURCE_DIR) / "../shared/data" / GetParam();
    if (!std::filesystem::exists(file_)) {
      GTEST_SKIP() << "no recordings of people beside this checkout";
    }
  }
  std::shared_ptr<const core::Kinematics> kinematics_ =
      core::make_finger_exoskeleton(core::finger_sign_change());
  std::filesystem::path file_;
};

TEST_P(Recordings, ReplayEveryRowInReach) {
  const std::vector<Row> rows = rows_of(file_);
  std::size_t outside = 0, gaps = 0;
  std::vector<bool> in_reach;
  core::VecX x(2);
  core::VecQ q;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    x << rows[i].mcp, rows[i].pip;
    in_reach.push_back(kinematics_->inverse(x, q) == core::InverseStatus::kExact);
    outside += in_reach.back() ? 0 : 1;
    gaps += i > 0 && rows[i].time - rows[i - 1].time > 0.0500005 ? 1 : 0;
  }
  ReplayConfig config;
  config.file = file_;
  config.max_effort = core::VecA::Constant(1, 40.0);
  Replay device(config, kinematics_);
  EXPECT_EQ(device.facts().rows, rows.size());
  EXPECT_EQ(device.facts().replaced, outside);
  EXPECT_EQ(device.facts().gaps, gaps);
  EXPECT_NEAR(core::seconds(device.facts().length), rows.back().time - rows.front().time, 1e-8);

  // At the time of every row the map gives the row's angles back, where they were in reach.
  core::DeviceReading reading;
  const core::TimePoint start(std::chrono::seconds(3));
  core::MatXQ J(2, 2);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    device.read(start + core::Duration(std::llround((rows[i].time - rows[0].time) * 1e9)), reading);
    ASSERT_TRUE(reading.fresh) << "row " << i;
    if (!in_reach[i]) continue;
    ASSERT_EQ(kinematics_->evaluate(reading.sample.q, x, J), core::MapStatus::kOk);
    EXPECT_NEAR(x[0], rows[i].mcp, 1e-9) << "row " << i;
    EXPECT_NEAR(x[1], rows[i].pip, 1e-9) << "row " << i;
  }
}

TEST_P(Recordings, MoveTheSimulatedFinger) {
  const std::vector<Row> rows = rows_of(file_);
  SimulatedHandConfig config;
  config.motion_file = file_;
  SimulatedHand device(config, kinematics_);
  test::VirtualLoop loop(device);
  double furthest = 0.0;
  for (int ms = 0; ms < 1500 + static_cast<int>(1000 * rows.back().time); ++ms) {
    ASSERT_TRUE(loop.tick().fresh);
    ASSERT_TRUE(loop.reading().sample.q.allFinite());
    furthest = std::max(furthest, device.fingers()[0].x().norm());
    const FingerEnergy& e = device.fingers()[0].energy();
    ASSERT_LE(device.fingers()[0].kinetic(), e.by_user + 1e-5) << "ms " << ms;
  }
  EXPECT_GT(furthest, 0.5);
}

INSTANTIATE_TEST_SUITE_P(OfPeople, Recordings,
                         testing::Values("dfki_pillow_grasps_100hz.csv", "leap_dropouts_74hz.csv",
                                         "leap_fist_selfocclusion_110hz.csv",
                                         "leap_grab_115hz.csv"),
                         [](const auto& recording) {
                           const std::string name = recording.param;
                           return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace haptic::hw
