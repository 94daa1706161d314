// Every shipped scene is pressed against a wall and let go: force in contact, none outside, no
// fault, and no more energy than its tank began with.
#include <algorithm>
#include <numbers>

#include "hw/bookkeeping.hpp"
#include "hw/device_limits.hpp"
#include "tests/server/owner/scene/scene_run.hpp"
#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

using core::VecA;
using core::VecQ;

/// A device that is where the test says, whatever force it gets.
struct LedConfig final : hw::DeviceConfig {
  std::shared_ptr<VecQ> q{};
  VecA max_effort{};
  [[nodiscard]] std::unique_ptr<hw::Device> open(std::shared_ptr<const core::Kinematics> kinematics,
                                                 core::Duration longest_lateness) const override;
  [[nodiscard]] VecA effort() const override { return max_effort; }
};

class Led final : public hw::Device {
 public:
  Led(const LedConfig& config, const core::Kinematics& kinematics) : q_(config.q) {
    info_.limits = hw::device_limits(kinematics, config.max_effort);
    info_.dofs = kinematics.dofs();
  }
  [[nodiscard]] const hw::DeviceInfo& info() const noexcept override { return info_; }
  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override {
    if (book_.begin_read(now, reading)) book_.deliver(now, *q_, reading);
  }
  void write(core::TimePoint, const hw::Command& command) noexcept override {
    static_cast<void>(book_.follows(command));
  }
  void close() noexcept override { book_.close(); }

 private:
  hw::DeviceInfo info_{};
  hw::Bookkeeping book_{};
  std::shared_ptr<VecQ> q_;
};

std::unique_ptr<hw::Device> LedConfig::open(std::shared_ptr<const core::Kinematics> kinematics,
                                            core::Duration /*longest_lateness*/) const {
  return std::make_unique<Led>(*this, *kinematics);
}

/// A straight way into the wall: q = wall + depth way.
struct Way {
  VecQ wall{}, way{};
};

/// The joints of fingers flex from 30 to 40 degrees; other devices move their actuators from where
/// the hand holds them, as far as a third of the force limit bends Z_q.
Way way_of(const server::DeviceScene& device) {
  const core::Kinematics& kinematics = *device.pipeline.kinematics;
  const core::DofLayout& layout = kinematics.layout();
  const auto joints = [&](double degrees) {
    return core::VecX(
        core::VecX::Constant(kinematics.space().n_x(), degrees * std::numbers::pi / 180.0));
  };
  Way way{VecQ::Zero(layout.n_q()), VecQ::Zero(layout.n_q())};
  if (kinematics.inverse(joints(30), way.wall) == core::InverseStatus::kExact) {
    VecQ deep = way.wall;
    EXPECT_EQ(kinematics.inverse(joints(40), deep), core::InverseStatus::kExact);
    way.way = deep - way.wall;
    return way;
  }
  way.wall = rest_of(device);
  const core::RenderSettings& settings = device.pipeline.scene;
  for (int i = 0; i < layout.n_a(); ++i) {
    way.way[layout.actuated(i)] = settings.force_limit[i] / settings.stiffness[i] / 3.0;
  }
  return way;
}

/// At rest on a board, of which no inertia is known, so that nothing is lent: a proxy 6 degrees off
/// at Engage. A tank that begins empty pays for none of it.
TEST(SceneRest, WhatEngageAcceptsIsFelt) {
  for (const bool strict : {false, true}) {
    const server::Scene scene =
        parse(strict ? with_option(kBoard, "passivity { tank {} }") : kBoard);
    const server::DeviceScene& device = scene.devices[0];
    const core::Kinematics& finger = *device.pipeline.kinematics;
    const auto at = [&](double degrees) {
      VecQ q = VecQ::Zero(2);
      EXPECT_EQ(finger.inverse(core::VecX::Constant(2, degrees * std::numbers::pi / 180.0), q),
                core::InverseStatus::kExact);
      return q;
    };
    LedConfig led;
    led.max_effort = device.source->effort();
    led.q = std::make_shared<VecQ>(at(30));
    SceneRun run(device, led);
    run.hold(at(24));
    run.engage();
    const double spring = 1500.0 * (at(24)[0] - at(30)[0]);
    EXPECT_GT(std::abs(spring), 2.5) << "half of what Engage accepts, at least";
    EXPECT_NEAR(run.record().effort.tau_a[0] / spring, strict ? 0.0 : 1.0, strict ? 1e-9 : 0.05);
  }
}

/// Mean length of the elastic force, N, of a proxy that is displaced by 0.9 of the engage window
/// when force begins, and moves by itself to 0.4 of the force limit.
double rested_force(const server::DeviceScene& device) {
  const core::DofLayout& layout = device.pipeline.kinematics->layout();
  const core::RenderSettings& settings = device.pipeline.scene;
  const VecQ rest = rest_of(device);
  SceneRun run(device);
  const auto pull = [&](const VecA& force) {
    VecQ q = rest;
    for (int i = 0; i < layout.n_a(); ++i)
      q[layout.actuated(i)] += force[i] / settings.stiffness[i];
    run.hold(q);
  };
  const VecA begin = 0.9 * settings.engage_window, end = 0.4 * settings.force_limit;
  pull(begin);
  run.engage();
  run.run(600);
  for (int frame = 1; frame <= 50; ++frame) {
    pull(begin + frame / 50.0 * (end - begin));
    run.run(10);
  }
  double sum = 0.0;
  for (int tick = 0; tick < 1000; ++tick) sum += run.tick().effort.tau_elastic.norm();
  return sum / 1000.0;
}

/// Why a tank begins with what the engage window stores: with less, a proxy that moves by itself
/// loses force.
TEST(SceneRest, WindowsEnergyCarriesAMovedProxy) {
  for (const char* name : {"linear_one_dof", "linear_underactuated", "stylus_three_of_six",
                           "chain_pick_arm", "chain_redundant"}) {
    SCOPED_TRACE(name);
    server::DeviceScene device = shipped_scene(name).devices[0];
    core::TankSettings& tank = device.pipeline.passivity.tank;
    const double level = tank.initial;
    tank.enabled = false;
    const double whole = rested_force(device);
    tank.enabled = true;
    const auto felt = [&](double share) {
      tank.initial = share * level;
      return rested_force(device) / whole;
    };
    EXPECT_EQ(felt(0.0), 0.0);
    EXPECT_LT(felt(0.25), 0.7);
    EXPECT_GT(felt(1.0), 0.999);
  }
}

/// One motor, two sensed joints: the prior decides how much of a contact the motor feels.
TEST(SceneRest, PriorSaysWhatIsFelt) {
  const auto limiters = [](double sensed_stiffness) {
    server::DeviceScene device = shipped_scene("linear_one_motor").devices[0];
    device.pipeline.projection.prior->sensed_stiffness.setConstant(sensed_stiffness);
    VecQ q = rest_of(device);
    SceneRun run(device);
    q.array() -= 0.05;
    run.hold(q);
    run.engage();
    return std::pair(run.record().limiters(), run.record().effort.tau_elastic.norm());
  };
  const auto [felt, force] = limiters(0.3);
  EXPECT_FALSE(felt.has(core::Limiter::kNotFelt));
  EXPECT_GT(force, 0.005);
  EXPECT_TRUE(limiters(1e-5).first.has(core::Limiter::kNotFelt));
}

class ScenePress : public testing::TestWithParam<std::string> {};

TEST_P(ScenePress, IsSafeAndFelt) {
  const server::Scene scene = shipped_scene(GetParam());
  for (const server::DeviceScene& device : scene.devices) {
    SCOPED_TRACE(device.name);
    const core::DofLayout& layout = device.pipeline.kinematics->layout();
    const Way way = way_of(device);
    LedConfig led;
    led.max_effort = device.source->effort();
    led.q = std::make_shared<VecQ>(way.wall - 0.5 * way.way);
    SceneRun run(device, led);
    run.free();
    run.engage();

    const VecA way_a = layout.select(way.way);
    const VecA b = device.pipeline.passivity.device_damping;
    double given = 0.0, most_given = 0.0;
    VecA held = VecA::Zero(layout.n_a());
    bool was_free = true;
    for (int frame = 0; frame < 450; ++frame) {  // three times 0.5 s in, 0.5 s held, 0.5 s out
      const auto depth_at = [&](int ms) {
        const double t = std::clamp(1e-3 * (ms % 1500) / 0.5, 0.0, 3.0);
        const double in = t < 1.0 ? t : std::min(1.0, 3.0 - t);
        return -0.5 + 1.5 * 0.5 * (1.0 - std::cos(std::numbers::pi * in));
      };
      const bool touches = depth_at(10 * frame) > 0.0;
      touches ? run.hold(way.wall) : run.free();
      for (int tick = 1; tick <= 10; ++tick) {
        const VecA before = layout.select(*led.q);
        *led.q = way.wall + depth_at(10 * frame + tick) * way.way;
        const VecA dq = layout.select(*led.q) - before;
        given += held.dot(dq) - dq.dot(b.cwiseProduct(dq)) / 1e-3;
        most_given = std::max(most_given, given);
        const core::TickRecord& record = run.tick();
        held = record.effort.tau_a;
        ASSERT_FALSE(record.faults().any());
        ASSERT_EQ(record.life.state, core::LifecycleState::kEngaged);
        if (!touches && was_free) {
          ASSERT_EQ(record.effort.tau_elastic.norm(), 0.0) << frame;
        }
      }
      was_free = !touches;
      if (frame % 150 == 99) {  // held at its deepest for half a second
        const VecA spring = device.pipeline.scene.stiffness.cwiseProduct(way_a);
        for (int i = 0; i < layout.n_a(); ++i) {
          EXPECT_GT(-held[i] / spring[i], 0.2) << i << ", press " << frame / 150;
        }
      }
    }
    EXPECT_LE(most_given, device.pipeline.passivity.tank.initial + 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, ScenePress, testing::ValuesIn(shipped_names()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace haptic::test
