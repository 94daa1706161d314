#include "hw/emulator/told_hand.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <string>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/emulator/truth_log.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::hw::emulator {
namespace {

struct Pipe {
  Pipe() { EXPECT_EQ(::pipe(ends), 0); }
  ~Pipe() {
    ::close(ends[0]);
    if (ends[1] >= 0) ::close(ends[1]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void say(const std::string& text) const {
    EXPECT_EQ(::write(ends[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  int ends[2]{-1, -1};
};

struct ToldRig : ::testing::Test {
  std::shared_ptr<const core::Kinematics> kinematics = core::make_finger_exoskeleton({});
  Rig rig{{}, {}, HandIntent(Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()), kinematics, 1};
  Pipe pipe;
  ToldHand hand{pipe.ends[0]};

  /// The motor gives way to whatever the load cell says, as a board's zero-force loop does.
  void pass(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / Rig::kStep); ++i) {
      const double push = rig.actuator().force();
      rig.actuator().drive(-60.0 * push, true);
      rig.step();
      if (i % 10 == 0) hand.follow(rig);
    }
  }
};

TEST(HandLine, IsTwoAnglesOrLetGo) {
  EXPECT_EQ(parse_hand(" 0.25  -0.5\r"), Eigen::Vector2d(0.25, -0.5));
  EXPECT_FALSE(parse_hand("let-go").has_value());
  for (const char* line :
       {"", "0.25", "0.25 x", "0.25 0.5 0.75", "let-go 1", "nan 0.1", "0,2 0,3"}) {
    EXPECT_THAT(test::message_of<core::DeviceError>([&] { return parse_hand(line); }),
                testing::HasSubstr("must be MCP PIP"))
        << line;
  }
}

TEST_F(ToldRig, TheHandObeys) {
  pipe.say("0.5 0.6\n");
  pass(3.0);
  EXPECT_NEAR(rig.finger().x()[0], 0.5, 0.05);
  EXPECT_NEAR(rig.finger().x()[1], 0.6, 0.05);
  pipe.say("0.2 ");  // a line that comes in two pieces
  pass(0.1);
  pipe.say("0.2\nnonsense\n");
  pass(3.0);
  EXPECT_NEAR(rig.finger().x()[0], 0.2, 0.05);
  ::close(pipe.ends[1]);
  pipe.ends[1] = -1;
  pass(0.5);
  EXPECT_NEAR(rig.finger().x()[0], 0.2, 0.05) << "nobody tells it anything any more";
}

TEST_F(ToldRig, LettingGoLeavesNoForce) {
  pipe.say("0.5 0.6\n");
  pass(0.4);  // on its way: the rod, switched off below, holds and the hand pushes
  rig.actuator().drive(0.0, false);
  const auto rest = [&] {
    for (int i = 0; i < 20000; ++i) {
      rig.step();
      if (i % 10 == 0) hand.follow(rig);
    }
  };
  rest();
  EXPECT_GT(std::abs(rig.actuator().force()), 1.0);
  pipe.say("let-go\n");
  rest();
  EXPECT_EQ(rig.actuator().force(), 0.0);
}

TEST(TruthLog, WritesTheTruthEvery10Milliseconds) {
  const test::TemporaryFile file("", "truth.csv");
  EmulatorConfig config;
  config.l_x_offset = 0.003;  // the sensor's business, not the truth's
  EmulatedBoard board(config, HandIntent(Eigen::Vector2d::Zero(), Eigen::Vector2d(0.5, 0.5)),
                      core::make_finger_exoskeleton({}));
  {
    TruthLog log(file.path().string());
    for (std::uint64_t ms = 1; ms <= 100; ++ms) {
      board.advance(1000 * ms);
      log.write(board);
    }
  }
  std::ifstream csv(file.path());
  std::string header, row, last;
  std::getline(csv, header);
  int rows = 0;
  for (; std::getline(csv, row); ++rows) last = row;
  EXPECT_EQ(header, "time_s,l_x_m,q_B_rad,force_n");
  EXPECT_EQ(rows, 10);
  double t = 0.0, l_x = 0.0;
  char comma = ' ';
  std::istringstream(last) >> t >> comma >> l_x;
  EXPECT_NEAR(l_x, board.rig().actuator().x(), 1e-4);
  EXPECT_NEAR(t, 0.091, 1e-9);
  EXPECT_THROW(TruthLog("/nowhere/truth.csv"), core::DeviceError);
}

}  // namespace
}  // namespace haptic::hw::emulator
