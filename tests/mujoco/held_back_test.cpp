/// The force that is told is the force that holds the tool back, whatever the model is made of, or
/// the client says so. HAPTIC_PRESSES: how many per model; its figures are printed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/mujoco/mujoco_world.hpp"
#include "tests/support/mujoco/pressed_models.hpp"

namespace haptic::mujoco {
namespace {

using testing::HasSubstr;
constexpr double kMost = 0.02, kSmall = 0.05;
constexpr double kFelt = 1e-3;  // of displacement, rad or m: presses that are less are not felt

/// MuJoCo's warnings.
std::vector<std::string> said;

struct Rig {
  explicit Rig(const test::PressedModel& m) : model(m), world(m.mjcf), tool(make()) {}
  Tool make() {
    said.clear();
    mju_user_warning = [](const char* text) { said.emplace_back(text); };
    return {world.m(),
            world.d(),
            model.bindings,
            {.coupling = model.coupling,
             .weights = model.weights,
             .keep_actuators = model.keep_actuators}};
  }

  /// Goes there, and holds until it rests. Per coordinate: told, and held back by the coupling's
  /// spring and, of joints, by MuJoCo's constraints.
  void press(const std::vector<double>& probe) {
    const std::vector<double> from = before.empty() ? std::vector<double>(probe.size()) : before;
    client::Proxy proxy;
    for (int i = 1; i <= 45; ++i) {
      std::vector<double> x = probe;
      const double part = std::min(1.0, i / 10.0);
      for (std::size_t c = 0; c < x.size(); ++c) x[c] = from[c] + part * (probe[c] - from[c]);
      proxy = tool.step(x, 1.0 / 60.0);
    }
    before = probe;
    const std::size_t n = probe.size();
    told.assign(n, 0.0);
    spring = constraint = told;
    for (std::size_t c = 0; c < proxy.position.size(); ++c) {
      told[c] = model.coupling * (probe[c] - proxy.position[c]);
    }
    for (const Binding& one : model.bindings) hold(one, probe);
  }
  void hold(const Binding& one, const std::vector<double>& probe) {
    const mjModel& m = *world.m();
    const mjData& d = *world.d();
    const std::size_t c = one.first_coordinate;
    if (one.kind == Binding::Kind::kJoint) {
      const int id = world.id(mjOBJ_JOINT, one.name.c_str());
      const double at = (d.qpos[m.jnt_qposadr[id]] - one.offset) / one.scale;
      if (constraint[c] == 0.0) spring[c] = model.coupling * (probe[c] - at);
      constraint[c] -= one.scale * d.qfrc_constraint[m.jnt_dofadr[id]];
      return;
    }
    const int body = world.id(mjOBJ_BODY, one.name.c_str());
    for (std::size_t k = 0; k < 3; ++k) {
      const double force = model.coupling * (probe[c + k] - d.xpos[3 * body + static_cast<int>(k)]);
      spring[c + k] = constraint[c + k] = force;
    }
    for (std::size_t k = 3; k < test::width(one); ++k) told[c + k] = 0.0;
  }
  /// Largest difference of what is told to one of both, of what holds back.
  [[nodiscard]] double off(const std::vector<double>& held) const {
    double most = 0.0, worst = 0.0;
    for (const double one : held) most = std::max(most, std::abs(one));
    for (std::size_t c = 0; c < held.size(); ++c) {
      const double least = std::max({std::abs(held[c]), kSmall * most, kFelt * model.coupling});
      worst = std::max(worst, std::abs(told[c] - held[c]) / least);
    }
    return worst;
  }
  [[nodiscard]] bool touches() const {
    return std::any_of(told.begin(), told.end(), [](double one) { return one != 0.0; });
  }

  test::PressedModel model;
  World world;
  Tool tool;
  std::vector<double> before{}, told{}, spring{}, constraint{};
};

TEST(HeldBack, IsWhatIsTold) {
  const char* const wish = std::getenv("HAPTIC_PRESSES");
  const int presses = wish != nullptr ? std::atoi(wish) : 20;
  int quiet = 0, all = 0;
  for (const test::PressedModel& model : test::pressed_models()) {
    SCOPED_TRACE(model.name);
    Rig rig(model);
    const std::vector<std::string> off = std::move(said);
    said.clear();
    double spring = 0.0, constraint = 0.0;
    int touched = 0;
    for (const std::vector<double>& probe : test::presses(model, presses)) {
      rig.press(probe);
      spring = std::max(spring, rig.off(rig.spring));
      constraint = std::max(constraint, rig.off(rig.constraint));
      touched += rig.touches() ? 1 : 0;
    }
    const bool warned = !said.empty();
    std::printf(
        "%-48s %3d of %3d press, off by %6.3f %% of the spring, %6.3f %% of constraints%s\n",
        model.name.c_str(), touched, presses, 100.0 * spring, 100.0 * constraint,
        warned ? ", warned" : "");
    for (const std::string& text : off) std::printf("    %s\n", text.c_str());
    if (warned) std::printf("    %s\n", said.front().c_str());
    EXPECT_TRUE(warned || touched >= presses / 2);
    EXPECT_EQ(warned, model.warned.value_or(warned));
    if (!warned) {
      EXPECT_LE(spring, kMost);
      EXPECT_LE(constraint, kMost);
    }
    ++all;
    quiet += warned ? 0 : 1;
  }
  std::printf("%d of %d without a warning%s\n", quiet, all,
              test::has_cases() ? "" : "; left out: ../shared/cases, which is not here");
  EXPECT_GE(all, 30);
  EXPECT_GE(quiet, 24);
}

/// A model's servos are off, and the finger follows as without them; or they stay, and it is said.
TEST(HeldBack, ServosAreSaidByName) {
  test::PressedModel model{
      .mjcf = test::finger_of(
          {.beyond = test::mimic("0 0.67 0 0 0") + R"(<actuator><position name="knuckle" joint="mcp"
         kp="1"/><position joint="dip" kp="1"/></actuator>)"})};
  Rig off(model);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0], HasSubstr("'knuckle', that of joint 'dip'"));
  const auto follows = [](Rig& rig) {
    rig.press({-0.4, 0.1});
    return rig.world.d()->qpos[0] + 0.4;
  };
  EXPECT_NEAR(follows(off), 0.0, 1e-6);
  EXPECT_EQ(said.size(), 1u);
  model.keep_actuators = true;
  Rig stay(model);
  EXPECT_TRUE(said.empty());
  EXPECT_GT(follows(stay), 0.2);
  ASSERT_FALSE(said.empty());
  EXPECT_THAT(said[0], HasSubstr("'mcp'"));
  EXPECT_THAT(said[0], HasSubstr("actuators are not told"));
}

}  // namespace
}  // namespace haptic::mujoco
