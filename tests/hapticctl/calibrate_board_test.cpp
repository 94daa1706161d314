// The guide, a script that answers it, and an emulated board whose potentiometer is wrong, in
// virtual time. With the calibration that results, the board's readings must be right.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <sstream>

#include "calibration/guide.hpp"
#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/virtual_board.hpp"

namespace haptic::ctl {
namespace {

using hw::emulator::EmulatorConfig;
using hw::emulator::VirtualBoard;

/// Joint angles of the hand that brings the device to its places: 5 s at each of two, again and
/// again.
class Motion {
 public:
  Motion() {
    std::ofstream csv(file_.path());
    csv << "time_s,q_o1_mcp_rad,q_o2_pip_rad\n";
    for (int half = 0; half < 40; ++half) {
      const bool bent = half % 2 == 1;
      for (const double t : {0.0, 5.0}) {
        csv << 6.0 * half + t << ',' << (bent ? 0.7 : 0.2) << ',' << (bent ? 0.9 : 0.2) << '\n';
      }
    }
  }
  [[nodiscard]] hw::Intent intent() const { return {Eigen::Vector2d::Zero(), file_.path()}; }

 private:
  test::TemporaryFile file_{};
};

hw::BoardConfig wanted() {
  hw::BoardConfig config;
  config.max_effort = core::VecA::Constant(1, 40.0);
  return config;
}

/// The board, armed at zero force, so that its actuator follows the hand.
class BoardSensors final : public Sensors {
 public:
  explicit BoardSensors(VirtualBoard& device) : device_(device) {
    command_.arm = true;
    command_.tau_a = core::VecA::Zero(1);
  }
  void begin() override { seen_ = {}; }
  Statistics end() override {
    Statistics answer = seen_;
    for (double& sum : answer.mean) sum /= static_cast<double>(answer.samples);
    for (double& sum : answer.force) sum /= static_cast<double>(answer.samples);
    return answer;
  }
  void switch_off() override { command_.arm = false; }
  void pause(double seconds) override {
    for (int ms = 0; ms < static_cast<int>(1e3 * seconds); ++ms) tick();
  }
  /// Until the finger is bent (straight) and the rod has come to rest behind it.
  void wait_for(bool bent) {
    do {
      tick();
    } while (static_cast<int>(device_.board().rig().elapsed() / 6.0) % 2 != (bent ? 1 : 0) ||
             std::fmod(device_.board().rig().elapsed(), 6.0) < 3.5 ||
             std::fmod(device_.board().rig().elapsed(), 6.0) > 3.6);
  }

 private:
  void tick() {
    now_ += std::chrono::milliseconds(1);
    device_.read(now_, reading_);
    device_.write(now_, command_);
    if (!reading_.fresh) return;
    const core::VecQ& q = reading_.sample.q;
    const std::vector<double> now(q.data(), q.data() + q.size());
    if (seen_.samples++ == 0) {
      seen_.mean.assign(now.size(), 0.0);
      seen_.lowest = seen_.highest = now;
      seen_.force = {0.0};
    }
    for (std::size_t i = 0; i < now.size(); ++i) {
      seen_.mean[i] += now[i];
      seen_.lowest[i] = std::min(seen_.lowest[i], now[i]);
      seen_.highest[i] = std::max(seen_.highest[i], now[i]);
    }
    seen_.force[0] += reading_.sample.tau_measured[0];
  }

  VirtualBoard& device_;
  core::TimePoint now_{std::chrono::hours(1)};
  core::DeviceReading reading_{};
  hw::Command command_{};
  Statistics seen_{};
};

/// Lines of text that are made when they are asked for.
class Person : public std::stringbuf {
 public:
  std::vector<std::function<std::string()>> answers{};

 protected:
  int_type underflow() override {
    if (next_ >= answers.size()) return traits_type::eof();
    str(answers[next_++]() + "\n");
    return traits_type::to_int_type(str().front());
  }

 private:
  std::size_t next_{0};
};

/// The board of a scene that names the file of a calibration.
hw::BoardConfig calibrated_by(const std::string& text) {
  const test::TemporaryFile file(text, "hand.calibration.textproto");
  const std::string scene =
      "name: \"calibrated\" device { name: \"finger\" finger_exoskeleton {}"
      " board { port: \"/dev/none\" max_effort: 40 calibration_file: \"" +
      file.path().string() +
      "\" } impedance { stiffness_n_per_m: 500 damping_n_s_per_m: 0.5 }"
      " limits { force_n: 20 } }";
  return dynamic_cast<const hw::BoardConfig&>(
      *server::parse_scene(scene, "test", "/").devices[0].source);
}

struct Held {
  double l_x{0.0};       ///< m, the newest sample
  double q_B{0.0};       ///< rad, the same
  double measured{0.0};  ///< N, mean of a second
  double force{0.0};     ///< N, the true one, mean of the same
};

/// Two seconds at a force, while the hand rests in the one place; the second of them counts.
Held hold(VirtualBoard& device, double tau_a) {
  hw::Command command{true, core::VecA::Constant(1, tau_a), {}};
  core::DeviceReading reading;
  Held held;
  const double start = device.board().rig().elapsed();
  for (int ms = 1; ms <= 2000; ++ms) {
    device.read(core::TimePoint(std::chrono::milliseconds(static_cast<int>(1e3 * start) + ms)),
                reading);
    device.write(core::TimePoint(std::chrono::milliseconds(static_cast<int>(1e3 * start) + ms)),
                 command);
    if (ms <= 1000) continue;
    held.measured += 1e-3 * reading.sample.tau_measured[0];
    held.force += 1e-3 * device.board().rig().actuator().force();
  }
  held.l_x = reading.sample.q[0];
  held.q_B = reading.sample.q[1];
  return held;
}

std::string exactly(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

TEST(CalibrateBoard, CorrectsAWrongPotentiometer) {
  const Motion motion;
  EmulatorConfig config{.l_x_scale = 1.08, .l_x_offset = 0.002, .force_offset = 0.8};
  const std::shared_ptr<const core::Kinematics> kinematics = core::make_finger_exoskeleton({});
  VirtualBoard device(config, motion.intent(), wanted(), kinematics);
  BoardSensors sensors(device);
  const auto at = [&](bool bent, int dof) {
    return [&, bent, dof] {
      sensors.wait_for(bent);
      const auto& rig = device.board().rig();
      return exactly(dof == 0 ? rig.actuator().x() : rig.finger().q()[1]);
    };
  };
  const auto through = [&] {
    sensors.wait_for(true);
    sensors.wait_for(false);
    return std::string();
  };
  Person person;
  const auto go_off = [] { return std::string(); };
  const auto let_go = [&] {
    device.board().rig().let_go();
    return std::string();
  };
  person.answers = {at(false, 0), at(true, 0), through, at(false, 1),
                    at(true, 1),  through,     go_off,  let_go};
  std::istream answers(&person);
  std::ostringstream asked;
  std::vector<client::DegreeOfFreedom> dofs;
  for (const core::DofSpec& dof : kinematics->dofs()) {
    dofs.push_back({dof.name, "", dof.actuated, dof.lower, dof.upper});
  }
  Guide guide(sensors, answers, asked);
  CalibrationResult result;
  ASSERT_NO_THROW(result = guide.run(dofs)) << asked.str();

  // reading = scale (l_x + offset), so l_x = reading / scale - offset; the means of a second leave
  // some hundredths of the 12 um quantum, and a slow creep of the rod.
  EXPECT_NEAR(result.dofs[0].scale, 1.0 / 1.08, 2e-3);
  EXPECT_NEAR(result.dofs[0].offset, -0.002, 5e-5);
  EXPECT_NEAR(result.dofs[1].scale, 1.0, 5e-3);
  EXPECT_NEAR(result.dofs[1].offset, 0.0, 5e-3);
  ASSERT_EQ(result.force_zero.size(), 1u);
  EXPECT_NEAR(result.force_zero[0], 0.8, 0.01) << "a second of 30 mN rms";

  // The file that was written is what a scene of the server reads back, and makes of the board.
  const hw::BoardConfig calibrated =
      calibrated_by(to_textproto(result, config.serial, "2026-11-21"));
  VirtualBoard again(config, motion.intent(), calibrated, kinematics);
  EXPECT_EQ(again.info().calibrated, "2026-11-21");
  EXPECT_NEAR(again.info().limits.q_upper[0], result.dofs[0].upper, 5e-3) << "the travel";
  for (const double tau_a : {0.0, 2.0}) {
    const Held held = hold(again, tau_a);
    EXPECT_NEAR(held.l_x, again.board().rig().actuator().x(), 1e-4);
    EXPECT_NEAR(held.q_B, again.board().rig().finger().q()[1], 5e-3);
    EXPECT_NEAR(held.measured, held.force, 0.02) << tau_a << " N asked for";
    // The board closes the loop on what its cell reads, 0.8 N more; what it holds is what was asked
    // for all the same, but for what friction leaves of it within the second.
    EXPECT_NEAR(held.force, tau_a, 0.4);
  }

  EmulatorConfig another = config;
  another.serial = "ANOTHER";
  try {
    const VirtualBoard refused(another, motion.intent(), calibrated, kinematics);
    FAIL() << "must throw";
  } catch (const core::DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("this one is 'ANOTHER'"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace haptic::ctl
