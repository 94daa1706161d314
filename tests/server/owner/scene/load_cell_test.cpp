// The load cell of the shipped force loops (core/METHOD.md#a-load-cell-that-lies): presses with an
// honest cell raise no fault; each lie is found, and the drive obeys the slew limit until then. The
// scene's pipeline on the emulated board, in virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>

#include "haptic/core/tick/pipeline.hpp"
#include "hw/board/board_device.hpp"
#include "hw/random.hpp"
#include "tests/server/owner/scene/scene_text.hpp"
#include "tests/support/held_proxy.hpp"
#include "tests/support/virtual_board.hpp"

namespace haptic::test {
namespace {

using core::Fault;
using core::LifecycleState;
using hw::emulator::BoardControl;
using hw::emulator::EmulatorConfig;
using hw::emulator::VirtualBoard;

constexpr int kSecond = 1000;  // ticks
constexpr double kSlew = 2.0;  // N per tick: 100 force_n per s by default, force_n: 20

/// The device of a shipped fragment; `by_default`: without what it says of its load cell.
server::DeviceScene fragment(const std::string& name, bool by_default = false) {
  const auto folder = kScenes / "fragments";
  std::ifstream file(folder / (name + ".textproto"));
  std::string text;
  for (std::string line; std::getline(file, line);) {
    const std::string field = line.substr(std::min(line.find_first_not_of(' '), line.size()));
    const bool of_cell = field.rfind("cell_", 0) == 0 || field.rfind("stuck_", 0) == 0 ||
                         field.rfind("drive_", 0) == 0;
    if (!by_default || !of_cell) text += line + "\n";
  }
  return server::parse_scene(text, name, folder).devices.at(0);
}

/// A finger on a board, under the force control of a scene, and a client with a wall per joint.
class Pressing {
 public:
  /// The cell's reading instead of `force`, `ms` after the lie began. N.
  using Lie = std::function<double(double force, int ms)>;

  Pressing(const server::DeviceScene& scene, const EmulatorConfig& board)
      : finger_(scene.pipeline.kinematics),
        device_(board, {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()}, uncalibrated(scene),
                finger_),
        pipeline_(server::pipeline_config(scene, device_.info().limits)) {
    input_.settings = pipeline_.config().scene;
    input_.command.tenure = 1;
    input_.command.lease_held = true;
  }

  const core::TickRecord& tick() {
    input_.now += std::chrono::milliseconds(1);
    device_.read(input_.now, input_.device);
    core::DeviceSample& sample = input_.device.sample;
    if (lie && input_.device.fresh) sample.tau_measured[0] = lie(sample.tau_measured[0], lied++);
    if (input_.device.fresh) publish(sample.q);
    if (record_.life.state == LifecycleState::kArmed) ++input_.command.engage_id;
    const double before = drive();
    record_ = pipeline_.tick(input_, proxy_);
    if (input_.device.fresh) {
      largest_reading = std::max(largest_reading, std::abs(sample.tau_measured[0]));
      const double now = sample.tau_measured[0];
      const double grown = std::max(now - std::max(0.0, reading_), std::min(0.0, reading_) - now);
      fastest = std::max(fastest, 1000.0 * grown);
      reading_ = now;
    }
    ++ticks_;
    if (drive() != 0.0) largest_step = std::max(largest_step, std::abs(drive() - before));
    device_.write(input_.now,
                  {record_.life.arm,
                   record_.effort.drive.size() > 0 ? record_.effort.drive : record_.effort.tau_a,
                   record_.effort.position});
    return record_;
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) tick();
  }
  void hand(double mcp, double pip) { device_.board().rig().take_to({mcp, pip}); }
  void let_go() { device_.board().rig().let_go(); }
  [[nodiscard]] double drive() const {
    const core::Effort& e = record_.effort;
    return e.drive.size() > 0 ? e.drive[0] : 0.0;
  }
  [[nodiscard]] double truth() { return device_.board().rig().actuator().force(); }
  [[nodiscard]] const core::TickRecord& last() const { return record_; }

  Eigen::Vector2d wall{0.3, 0.5};  ///< rad: no joint bends further
  int every{1};                    ///< ms between two samples of the client
  Lie lie{};
  int lied{0};
  double largest_step{0.0}, largest_reading{0.0}, fastest{0.0};

 private:
  static hw::BoardConfig uncalibrated(const server::DeviceScene& scene) {
    auto config = dynamic_cast<const hw::BoardConfig&>(*scene.source);
    config.calibration.reset();
    config.serial.clear();
    return config;
  }
  void publish(const core::VecQ& q) {
    core::VecX x;
    core::MatXQ J;
    if (ticks_ % every != 0 || q.size() != 2) return;
    if (finger_->evaluate(q, x, J) != core::MapStatus::kOk) return;
    publish_held(input_, x.cwiseMin(wall), proxy_);
  }

  std::shared_ptr<const core::Kinematics> finger_;
  VirtualBoard device_;
  core::Pipeline pipeline_;
  core::TickInput input_{};
  core::ProxySnapshot proxy_{};
  core::TickRecord record_{};
  double reading_{0.0};
  int ticks_{0};
};

struct Law {
  const char* scene;
  BoardControl control;
  bool by_default{false};  ///< thresholds of the load cell
};
constexpr Law kByForce{"force_loop_on_server", BoardControl::kDrive};
constexpr Law kByPosition{"admittance", BoardControl::kPosition};

TEST(LoadCell, HonestPressesRaiseNoFault) {
  int presses = 0, contacts = 0;
  for (const Law& law : {kByForce, kByPosition, Law{kByForce.scene, kByForce.control, true},
                         Law{kByPosition.scene, kByPosition.control, true}}) {
    double reading = 0.0, fastest = 0.0, step = 0.0, commanded = 0.0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      server::DeviceScene scene = fragment(law.scene, law.by_default);
      scene.pipeline.scene.stiffness.setConstant(seed % 2 == 0 ? 500.0 : 1000.0);
      Pressing finger(
          scene,
          {.seed = seed, .link_period_us = seed % 4 < 2 ? 0U : 2000U, .control = law.control});
      finger.every = seed % 3 == 0 ? 16 : 1;
      std::mt19937_64 random(seed);
      const auto between = [&](double low, double high) {
        return low + (high - low) * hw::uniform(random);
      };
      finger.run(kSecond / 2);
      for (int press = 0; press < 30; ++press, ++presses) {
        finger.wall = {between(0.0, 0.5), between(0.0, 0.9)};
        finger.hand(between(0.0, 1.2), between(0.0, 1.4));
        double most = 0.0;
        for (int i = 0; i < 1200; ++i) {
          if (press % 5 == 4 && i == 600) finger.wall.setZero();  // an object strikes the finger
          if (press % 7 == 6 && i == 700) finger.let_go();
          most = std::max(most, std::abs(finger.tick().effort.tau_a.sum()));
          ASSERT_FALSE(finger.last().faults().any())
              << law.scene << ", seed " << seed << ", press " << press << " at " << i
              << " ms: " << finger.last().faults().bits() << ", drive " << finger.drive()
              << " N, cell " << finger.last().sensed.tau_measured << " N at "
              << finger.last().sensed.q;
        }
        contacts += most > 2.0 ? 1 : 0;
        commanded = std::max(commanded, most);
      }
      reading = std::max(reading, finger.largest_reading);
      fastest = std::max(fastest, finger.fastest);
      step = std::max(step, finger.largest_step);
    }
    std::printf(
        "%-20s %scommanded up to %.1f N; the cell read up to %.1f N and grew by up to"
        " %.0f N/s; drive stepped by up to %.2f N\n",
        law.scene, law.by_default ? "by default " : "", commanded, reading, fastest, step);
    EXPECT_LE(step, 2.0 + 1e-9) << "the slew limit, N per tick";
  }
  std::printf("%d presses, %d of them above 2 N: no fault\n", presses, contacts);
  EXPECT_GE(contacts, 300);
}

/// A lie, and the ms after which each law has found it; 0: it may pass, because friction hides it,
/// or because the drive's force is not known.
struct NamedLie {
  const char* name;
  int by_force, by_position;
  Pressing::Lie lie;
};

TEST(LoadCell, EachLieIsFoundInTime) {
  hw::Gaussian noise(3);
  const NamedLie lies[] = {
      {"-60 N", 1, 1, [](double, int) { return -60.0; }},
      {"+-60 N in turn", 1, 1, [](double, int ms) { return ms % 2 == 0 ? 60.0 : -60.0; }},
      {"+-45 N in turn", 1, 1, [](double, int ms) { return ms / 50 % 2 == 0 ? 45.0 : -45.0; }},
      {"stuck at 0", 60, 350, [](double, int) { return 0.0; }},
      {"stuck at -8 N", 3000, 1100, [](double, int) { return -8.0; }},
      {"disconnected, 0 and noise", 600, 0, [&](double, int) { return 0.03 * noise(); }},
      {"wrong sign", 1, 0, [](double force, int) { return -force; }},
      {"drifts by 10 N/s", 2000, 9500, [](double force, int ms) { return force + 0.01 * ms; }},
      {"drifts by -10 N/s", 800, 7000, [](double force, int ms) { return force - 0.01 * ms; }},
      {"reads half", 0, 0, [](double force, int) { return 0.5 * force; }},
  };
  for (const Law& law : {kByForce, kByPosition}) {
    const bool by_force = law.control == BoardControl::kDrive;
    for (const NamedLie& named : lies) {
      const int in_time = by_force ? named.by_force : named.by_position;
      int latest = 0, found = 0;
      double step = 0.0, most = 0.0;
      core::FaultSet faults;
      constexpr int kRuns = 3;
      for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
        Pressing finger(fragment(law.scene), {.seed = seed, .control = law.control});
        finger.run(kSecond / 2);
        finger.hand(0.9, 0.9);
        finger.run(kSecond + 37 * static_cast<int>(seed));
        ASSERT_EQ(finger.last().life.state, LifecycleState::kEngaged);
        finger.largest_step = 0.0;
        finger.lie = named.lie;
        const double before = finger.truth();
        const int patience = in_time > 0 ? in_time : 3 * kSecond;
        for (int i = 0; i < patience && !finger.last().faults().any(); ++i) {
          finger.tick();
          most = std::max(most, std::abs(finger.truth() - before));
        }
        step = std::max(step, finger.largest_step);
        faults = faults | finger.last().faults();
        if (finger.last().life.state != LifecycleState::kFault) continue;
        ++found;
        latest = std::max(latest, finger.lied);
        EXPECT_EQ(finger.drive(), 0.0);
      }
      std::string said;
      for (const Fault fault : {Fault::kForceOutOfRange, Fault::kForceTooFast, Fault::kForceStuck,
                                Fault::kForceDisagrees}) {
        if (faults.has(fault)) said += " " + std::string(reason(fault));
      }
      std::printf(
          "%-20s %-26s found %d of %d, after %4d ms at most; drive stepped by %.2f N, true"
          " force moved by %4.1f N;%s\n",
          law.scene, named.name, found, kRuns, latest, step, most, said.c_str());
      EXPECT_TRUE(in_time == 0 || found == kRuns) << law.scene << ", " << named.name;
      EXPECT_TRUE(!by_force || step <= kSlew + 1e-9) << named.name << ": " << step;
    }
  }
}

}  // namespace
}  // namespace haptic::test
