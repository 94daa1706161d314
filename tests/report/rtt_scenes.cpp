// Devices and motions of rtt_study.hpp.
#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/motion/pchip.hpp"
#include "hw/simulated/hand.hpp"
#include "server/owner/scene/shipped.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/felt_study.hpp"
#include "tests/report/finger_press.hpp"
#include "tests/report/rtt_study.hpp"
#include "tests/support/loop/rails.hpp"

namespace haptic::report {
namespace {

using core::VecA;
using core::VecQ;

constexpr double kLongest = 12.0;  // s, of a recording
constexpr double kSeconds = 8.0;

/// Masses on rails, each moved by a hand through a spring and a damper.
class Masses final : public RttBody {
 public:
  explicit Masses(test::Hand hand) : masses_(std::move(hand)) {}
  void step(double t, const VecA& tau) override { masses_.step(t, tau); }
  [[nodiscard]] VecQ q() const override { return masses_.q(); }

 private:
  test::HandMasses masses_;
};

/// In and out of a wall at 0.
test::Hand in_and_out(double hz) {
  return test::swinging(hz, 0.018);
}

/// Down on the disc within a second, to and fro by 15 mm, and up in the last one.
template <int kHundredthsHz>
test::HandAim stroke(double t) {
  constexpr double kAbove = 0.010, kBelow = -0.009;  // m
  const double down = std::clamp(t, 0.0, 1.0), up = std::clamp(t - (kSeconds - 1.0), 0.0, 1.0);
  const auto way = [](double u) { return 0.5 - 0.5 * std::cos(M_PI * u); };
  const auto slope = [](double u) { return 0.5 * M_PI * std::sin(M_PI * u); };
  test::HandAim aim{VecQ(2), VecQ(2)};
  const double w = 2.0 * M_PI * 0.01 * kHundredthsHz, phase = w * std::max(t, 0.0);
  aim.at[0] = 0.015 * std::sin(phase);
  aim.rate[0] = t > 0.0 ? 0.015 * w * std::cos(phase) : 0.0;
  aim.at[1] = kAbove + (way(down) - way(up)) * (kBelow - kAbove);
  aim.rate[1] = (slope(down) - slope(up)) * (kBelow - kAbove);
  return aim;
}

/// Two fingers, 40 mm apart when they touch, each in and out by 12 mm in its own time.
test::HandAim pinch(double t) {
  test::HandAim aim{VecQ(2), VecQ(2)};
  test::swing(t, 0.7, -0.020, 0.012, 0, aim);
  test::swing(t, 0.5, 0.020, -0.012, 1, aim);
  return aim;
}

RttScene on_rails(const char* name, int n, const RttMaker& object, const test::Hand& hand) {
  RttScene scene{.name = name,
                 .object = object,
                 .pipeline = test::rails(n),
                 .device_damping = test::Rails::damping,
                 .body = [hand] { return std::make_unique<Masses>(hand); },
                 .seconds = kSeconds};
  scene.pipeline.passivity.tank.enabled = true;
  scene.most_damping = 0.5 * test::Rails::mass / 1e-3;
  return scene;
}

using Motion = std::function<Eigen::Vector2d(double t)>;

/// The exoskeleton on a finger that the hand moves and that gives way.
class WornFinger final : public RttBody {
 public:
  WornFinger(const FeltDevice& device, Motion aim)
      : aim_(std::move(aim)), physics_(device.finger, device.pipeline.kinematics, aim_(0.0)) {}

  void step(double t, const VecA& tau) override {
    step_tick(
        physics_, t, [this](double at) { return aim_(std::max(0.0, at)); }, tau[0]);
  }
  [[nodiscard]] VecQ q() const override { return physics_.q(); }

 private:
  Motion aim_;
  hw::FingerPhysics physics_;
};

/// The exoskeleton led along a motion, whatever it is told.
class LedFinger final : public RttBody {
 public:
  LedFinger(const FeltDevice& device, Motion aim)
      : aim_(std::move(aim)), map_(device.pipeline.kinematics), q_(VecQ::Zero(2)) {
    step(0.0, {});
  }
  void step(double t, const VecA&) override {
    static_cast<void>(map_->inverse(core::VecX(aim_(std::max(0.0, t))), q_));
  }
  [[nodiscard]] VecQ q() const override { return q_; }

 private:
  Motion aim_;
  std::shared_ptr<const core::Kinematics> map_;
  VecQ q_;
};

Motion recorded(const std::string& file, double& seconds) {
  const hw::MotionTable table = flexed_recording(file);
  const auto mcp = std::make_shared<hw::Pchip>(table.time_s, table.values[0]);
  const auto pip = std::make_shared<hw::Pchip>(table.time_s, table.values[1]);
  seconds = std::min(mcp->last(), kLongest);
  return [mcp, pip](double t) { return Eigen::Vector2d((*mcp)(t), (*pip)(t)); };
}

/// The demo's own grasp.
std::string own_motion() {
  const auto scene = server::find_scene("finger_soft_grasp");
  if (!scene) throw core::SceneError("rtt: no scene finger_soft_grasp");
  return (std::filesystem::path(*scene).parent_path() / "motion" / "reach_and_grasp.csv").string();
}

}  // namespace

std::vector<RttScene> rtt_scenes(const std::vector<std::string>& recordings) {
  std::vector<RttScene> all{
      on_rails("rigid_wall", 1, rtt_rigid_wall, in_and_out(0.7)),
      on_rails("soft_wall", 1, rtt_soft_wall, in_and_out(0.7)),
      on_rails("soft_wall_2hz", 1, rtt_soft_wall, in_and_out(2.0)),
      on_rails("stiffening", 1, rtt_stiffening_wall, in_and_out(0.7)),
      on_rails("stiffening_springs", 1, rtt_stiffening_springs, in_and_out(0.7)),
      on_rails("disc_70mm_s", 2, rtt_disc, stroke<54>),
      on_rails("disc_2hz", 2, rtt_disc, stroke<200>),
      on_rails("moving_soft", 1, rtt_moving_soft_wall, in_and_out(0.7)),
      on_rails("moving_rigid", 1, rtt_moving_rigid_wall, in_and_out(0.7)),
      on_rails("two_fingers", 2, rtt_block, pinch),
  };
  all.back().blocks = {{0, 1}, {1, 1}};
  // An object that moves by itself may work on the finger; a scene that has one says how much.
  for (RttScene& scene : all) {
    if (scene.name.rfind("moving_", 0) == 0) scene.pipeline.passivity.tank.allowed_power = 0.25;
  }
  const auto push = [&](const char* name, const RttPushed& what) {
    all.push_back(on_rails(
        name, 1, [what] { return rtt_pushed(what); }, in_and_out(0.7)));
    all.back().one_world = true;
  };
  push("pushed_right_0.02kg", {.mass = 0.02});
  push("pushed_right_0.2kg", {.mass = 0.2});
  push("pushed_right_2kg", {.mass = 2.0, .ground = 500.0});
  push("pushed_disturbed_0.2kg", {.mass = 0.2, .disturbance = 0.1});
  push("pushed_wrong_half_0.2kg", {.mass = 0.2, .told_mass = 0.5});
  push("pushed_wrong_double_0.2kg", {.mass = 0.2, .told_mass = 2.0});
  push("pushed_wrong_half_2kg", {.mass = 2.0, .ground = 500.0, .told_mass = 0.5});
  push("pushed_wrong_double_2kg", {.mass = 2.0, .ground = 500.0, .told_mass = 2.0});
  push("sliding_right_2kg", {.mass = 2.0, .ground = 0.0, .damping = 20.0});
  push("sliding_wrong_half_2kg", {.mass = 2.0, .ground = 0.0, .damping = 20.0, .told_mass = 0.5});
  push("sliding_wrong_double_2kg", {.mass = 2.0, .ground = 0.0, .damping = 20.0, .told_mass = 2.0});
  for (const RttPushed& what : {RttPushed{.mass = 0.2, .own_steps = true},
                                RttPushed{.mass = 2.0, .ground = 500.0, .own_steps = true}}) {
    push(what.mass < 1.0 ? "pushed_own_steps_0.2kg" : "pushed_own_steps_2kg", what);
    all.back().own = [what] { return rtt_pushed(what); };
  }
  for (const double mass : {0.2, 2.0}) {
    all.push_back(on_rails(
        mass < 1.0 ? "two_fingers_0.2kg" : "two_fingers_2kg", 2,
        [mass] { return rtt_pushed_block({.mass = mass, .damping = 20.0}); }, pinch));
    all.back().one_world = true;
    all.back().blocks = {{0, 1}, {1, 1}};
  }
  push("pushed_told_velocity_0.2kg", {.mass = 0.2, .told = RttPushed::kVelocity});
  push("pushed_told_surface_0.2kg", {.mass = 0.2, .told = RttPushed::kSurface});
  const auto device = std::make_shared<const FeltDevice>(
      felt_device(core::make_finger_exoskeleton(chosen_linkage())));
  std::vector<std::string> motions = recordings;
  motions.insert(motions.begin(), own_motion());
  for (const std::string& file : motions) {
    RttScene scene{.object = rtt_soft_finger,
                   .pipeline = device->pipeline,
                   .device_damping = device->finger.actuator_damping};
    scene.most_damping = 0.5 * device->finger.actuator_mass / 1e-3;
    const Motion motion = recorded(file, scene.seconds);
    const std::string of = std::filesystem::path(file).stem().string();
    scene.name = "finger_led_" + of;
    scene.body = [device, motion] { return std::make_unique<LedFinger>(*device, motion); };
    all.push_back(scene);
    scene.name = "finger_worn_" + of;
    scene.body = [device, motion] { return std::make_unique<WornFinger>(*device, motion); };
    all.push_back(std::move(scene));
  }
  return all;
}

}  // namespace haptic::report
