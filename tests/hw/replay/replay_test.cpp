#include "hw/replay/replay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "tests/hw/virtual_loop.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::hw {
namespace {

using namespace std::chrono_literals;
using test::TemporaryFile;
using test::VirtualLoop;
using testing::AllOf;
using testing::HasSubstr;

std::shared_ptr<const core::Kinematics> finger() {
  static const std::shared_ptr<const core::Kinematics> kFinger =
      core::make_finger_exoskeleton(core::finger_sign_change());
  return kFinger;
}

ReplayConfig playing(const TemporaryFile& file, bool repeat = false) {
  ReplayConfig config;
  config.file = file.path();
  config.repeat = repeat;
  config.max_effort = core::VecA::Constant(1, 40.0);
  return config;
}

/// Header for the finger's own DoFs, by the names its kinematics gives them.
std::string states(const std::string& rows) {
  const auto& dofs = finger()->dofs();
  return "time_s," + dofs[0].name + "," + dofs[1].name + "\n" + rows;
}

std::string angles(const std::string& rows) {
  return "time_s,q_o1_mcp_rad,q_o2_pip_rad\n" + rows;
}

TEST(Replay, DeviceStatesKeepTheirTiming) {
  const TemporaryFile file(states("10.00,0.010,0.10\n10.04,0.014,0.06\n10.08,0.018,0.02\n"));
  Replay device(playing(file), finger());
  EXPECT_FALSE(device.facts().joint_angles);
  VirtualLoop loop(device);
  for (int ms = 0; ms <= 80; ++ms) {
    const core::TimePoint now = loop.now();
    const core::DeviceReading& reading = loop.tick();
    ASSERT_TRUE(reading.fresh) << ms;
    EXPECT_EQ(reading.sample.seq, static_cast<std::uint64_t>(ms) + 1);
    EXPECT_EQ(reading.sample.time, now);
    // The rows lie on a straight line, so that their curve is the line.
    EXPECT_NEAR(reading.sample.q[0], 0.010 + 1e-4 * ms, 1e-12);
    EXPECT_NEAR(reading.sample.q[1], 0.10 - 1e-3 * ms, 1e-12);
  }
}

TEST(Replay, HandAnglesSurviveTheMap) {
  const std::shared_ptr<const core::Kinematics> hand =
      core::make_hand_exoskeleton({{"index", core::finger_sign_change()},
                                   {"ring", core::scaled(core::finger_sign_change(), 0.9)}});
  const TemporaryFile file(
      "time_s,ring.q_o2_pip_rad,index.q_o1_mcp_rad,index.q_o2_pip_rad,ring.q_o1_mcp_rad\n"
      "0,0.6,0.2,0.3,0.4\n0.04,0.7,0.3,0.5,0.4\n0.08,0.8,0.5,0.6,0.5\n");
  ReplayConfig config = playing(file);
  config.max_effort = core::VecA::Constant(2, 40.0);
  Replay device(config, hand);
  EXPECT_TRUE(device.facts().joint_angles);
  EXPECT_EQ(device.facts().replaced, 0u);
  const std::vector<double> time{0, 0.04, 0.08};
  const Pchip expected[] = {{time, {0.2, 0.3, 0.5}},
                            {time, {0.3, 0.5, 0.6}},
                            {time, {0.4, 0.4, 0.5}},
                            {time, {0.6, 0.7, 0.8}}};
  VirtualLoop loop(device);
  core::VecX x;
  core::MatXQ J;
  for (int ms = 0; ms <= 80; ++ms) {
    ASSERT_TRUE(loop.tick().fresh);
    ASSERT_EQ(hand->evaluate(loop.reading().sample.q, x, J), core::MapStatus::kOk);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(x[i], expected[i](0.001 * ms), 1e-12);
  }
}

TEST(Replay, AGapHasNoSamples) {
  const TemporaryFile file(
      states("0,0.01,0\n0.05,0.02,0\n0.101,0.03,0\n0.15,0.04,0\n"));  // 50 ms, 51 ms, 49 ms
  Replay device(playing(file), finger());
  EXPECT_EQ(device.facts().gaps, 1u);
  VirtualLoop loop(device);
  for (int ms = 0; ms <= 150; ++ms) {
    const bool gap = ms > 50 && ms < 101;
    EXPECT_EQ(loop.tick().fresh, !gap) << ms;
    EXPECT_EQ(loop.reading().health, core::DeviceHealth::kOk);
    if (gap) {
      EXPECT_NEAR(loop.reading().sample.q[0], 0.02, 1e-15) << ms;
    }
  }
}

TEST(Replay, EndsWithoutFurtherSamples) {
  const TemporaryFile file(states("0,0.01,0\n0.02,0.02,0\n"));
  Replay device(playing(file), finger());
  VirtualLoop loop(device);
  loop.run(21ms);
  EXPECT_TRUE(loop.reading().fresh);
  for (int ms = 0; ms < 3000; ++ms) EXPECT_FALSE(loop.tick().fresh);
  EXPECT_EQ(loop.reading().health, core::DeviceHealth::kOk);
}

TEST(Replay, ARepeatPausesHalfASecond) {
  const TemporaryFile file(states("0,0.01,0\n0.02,0.02,0\n"));
  Replay device(playing(file, true), finger());
  VirtualLoop loop(device);
  for (int ms = 0; ms < 2000; ++ms) {
    const int into = ms % 520;
    EXPECT_EQ(loop.tick().fresh, into <= 20) << ms;
    if (into == 0) {
      EXPECT_NEAR(loop.reading().sample.q[0], 0.01, 1e-15);
    }
  }
}

TEST(Replay, RowsOutOfReachAreReplaced) {
  // tests/report/STUDY.md#unreachable-proxies: two of its points with the end poses that the global
  // minimum has.
  const TemporaryFile file(angles("0,0.3,0.3\n0.04,-0.5,0.3\n0.08,-0.5,-0.5\n0.12,0.3,0.3\n"));
  Replay device(playing(file), finger());
  EXPECT_EQ(device.facts().replaced, 2u);
  EXPECT_THAT(device.info().model, HasSubstr("2 row(s) outside the reach"));
  constexpr double kDeg = 0.017453292519943295;
  VirtualLoop loop(device);
  loop.run(41ms);
  EXPECT_NEAR(loop.reading().sample.q[0], 0.01015, 1e-4);
  EXPECT_NEAR(loop.reading().sample.q[1], 41.5 * kDeg, 1e-3);
  loop.run(40ms);
  EXPECT_NEAR(loop.reading().sample.q[0], 0.0, 1e-4);
  EXPECT_NEAR(loop.reading().sample.q[1], 32.25 * kDeg, 1e-3);
}

TEST(Replay, TheReachEdgeIsContinuous) {
  std::ostringstream rows;
  for (int i = 0; i <= 100; ++i) {
    const double phase = 0.0628 * i;
    rows << 0.01 * i << "," << 0.6 + 1.1 * std::sin(phase) << "," << 0.7 + 1.3 * std::cos(phase)
         << "\n";
  }
  const TemporaryFile file(angles(rows.str()));
  Replay device(playing(file), finger());
  EXPECT_GT(device.facts().replaced, 20u);
  EXPECT_LT(device.facts().replaced, 100u);
  VirtualLoop loop(device);
  core::VecQ last = loop.tick().sample.q;
  for (int ms = 1; ms <= 1000; ++ms) {
    const core::VecQ q = loop.tick().sample.q;
    for (int i = 0; i < 2; ++i) {
      EXPECT_GE(q[i], finger()->dofs()[static_cast<std::size_t>(i)].lower - 1e-12);
      EXPECT_LE(q[i], finger()->dofs()[static_cast<std::size_t>(i)].upper + 1e-12);
    }
    EXPECT_LT(std::abs(q[0] - last[0]), 0.002) << ms;
    EXPECT_LT(std::abs(q[1] - last[1]), 0.05) << ms;
    last = q;
  }
}

TEST(Replay, ArmsButMovesNothing) {
  const TemporaryFile file(states("0,0.01,0\n1.0,0.01,0\n"));
  Replay device(playing(file), finger());
  EXPECT_FALSE(device.info().moves);
  EXPECT_EQ(device.info().kind, "replay");
  EXPECT_EQ(device.info().limits.silence_policy, core::SilencePolicy::kRampOut);
  EXPECT_EQ(device.info().limits.max_silence, 50ms);
  VirtualLoop loop(device);
  loop.push(30.0);
  EXPECT_FALSE(loop.tick().armed);
  EXPECT_TRUE(loop.tick().armed);
  EXPECT_NEAR(loop.reading().sample.q[0], 0.01, 1e-15);
  device.close();
  EXPECT_EQ(loop.tick().health, core::DeviceHealth::kLost);
  EXPECT_FALSE(loop.reading().armed);
}

TEST(Replay, RefusesAnImpossibleState) {
  const TemporaryFile file(states("0,0.01,0\n0.01,0.2,0\n"));
  EXPECT_THAT(test::message_of<core::DeviceError>([&] { return Replay(playing(file), finger()); }),
              AllOf(HasSubstr("motion.csv:3"), HasSubstr("= 0.2"), HasSubstr("-0.0025 to 0.0525")));
}

TEST(Replay, DoubtsUnitsOfStates) {
  const auto says = [](const char* rows, const char* sentence) {
    const TemporaryFile file(states(rows));
    EXPECT_THAT(
        test::message_of<core::DeviceError>([&] { return Replay(playing(file), finger()); }),
        AllOf(HasSubstr("motion.csv:2: column"), HasSubstr(sentence)));
  };
  says("0,20,0\n1,20,0\n",
       "l_x = 20: must lie within the device's range, -0.0025 to 0.0525 m: "
       "millimetres?");
  says("0,0.01,40\n1,0.01,40\n", " rad: degrees?");
  const TemporaryFile degrees(angles("0,30,30\n0.01,40,30\n"));
  const Replay device(playing(degrees), finger());
  ASSERT_EQ(device.info().notes.size(), 3u);
  EXPECT_THAT(device.info().notes[0], HasSubstr("q_o1_mcp_rad: values to 40: degrees?"));
  EXPECT_THAT(
      device.info().notes[2],
      HasSubstr("2 of 2 rows are outside the device's reach: replaced by the nearest pose"));
}

TEST(Replay, AllowsNoiseAtAStop) {
  const TemporaryFile file(states("0,-0.001,0\n0.01,0.0505,0\n"));
  EXPECT_NO_THROW(Replay(playing(file), finger()));
}

TEST(Replay, JointAnglesNeedAnInverse) {
  core::LinearMap map{.dofs = {{"z", core::Unit::kMetre, true, -1.0, 1.0}},
                      .coordinates = {{"z"}},
                      .A = core::MatXQ::Identity(1, 1),
                      .x_0 = core::VecX::Zero(1)};
  const std::shared_ptr<const core::Kinematics> linear = core::make_linear(map);
  const TemporaryFile own("time_s,z\n0,0.1\n0.04,0.3\n", "own.csv");
  Replay device(playing(own), linear);
  VirtualLoop loop(device);
  loop.run(21ms);
  EXPECT_NEAR(loop.reading().sample.q[0], 0.2, 1e-12);
  const TemporaryFile other(angles("0,0.1,0.1\n1,0.1,0.1\n"));
  EXPECT_THROW(Replay(playing(other), linear), core::DeviceError);
}

}  // namespace
}  // namespace haptic::hw
