#include "haptic/core/control/force_control.hpp"

#include <gtest/gtest.h>

#include "haptic/core/error.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

constexpr double T = 1e-3;
const ForceLoopGains kGains{2.0, 10.0, 0.0, 1.0, 20.0};
const AdmittanceParameters kAdmittance{0.0, 500.0, 0.05, 0.0, 0.05};

TEST(ForceControl, EachDofHasItsOwnLoop) {
  ForceControl control({{kGains, kGains}, {}}, 2);
  control.step(two(1.0, -2.0), two(0.5, -2.0), T);
  // u = reference + K_P e + K_I e T
  EXPECT_NEAR(control.drive()[0], 1.0 + 2.0 * 0.5 + 10.0 * 0.5 * T, 1e-12);
  EXPECT_NEAR(control.drive()[1], -2.0, 1e-12);
  EXPECT_EQ(control.position().size(), 0);
}

TEST(ForceControl, DoesNotIntegrateAnUnknownForce) {
  ForceControl control({{kGains}, {}}, 1);
  for (int i = 0; i < 1000; ++i) control.step(one(3.0), {}, T);
  EXPECT_EQ(control.drive()[0], 3.0) << "open loop";
  control.step(one(3.0), one(3.0), T);
  EXPECT_EQ(control.drive()[0], 3.0);
}

TEST(ForceControl, NamesTheDofAtItsLimit) {
  ForceControl control({{kGains, kGains}, {}}, 2);
  control.step(two(1.0, 19.0), two(1.0, 0.0), T);
  EXPECT_FALSE(control.limited(0));
  EXPECT_TRUE(control.limited(1));
  EXPECT_EQ(control.drive()[1], kGains.output_limit);
  control.rest(two(0.0, 0.0));
  EXPECT_FALSE(control.limited(1));
  EXPECT_EQ(control.drive()[1], 0.0);
}

TEST(ForceControl, AdmittanceStartsAtTheDevicesPosition) {
  ForceControl control({{}, {kAdmittance}}, 1);
  control.rest(one(0.02));
  control.step(one(0.0), one(0.0), T);
  EXPECT_EQ(control.position()[0], 0.02);
  EXPECT_EQ(control.drive().size(), 0);
  // d v = reference - measured: 5 N over 500 N s/m are 10 mm/s.
  control.step(one(5.0), one(0.0), T);
  EXPECT_NEAR(control.position()[0], 0.02 + 0.01 * T, 1e-12);
}

TEST(ForceControl, AnAdmittanceThatFeelsNothingStays) {
  ForceControl control({{}, {kAdmittance}}, 1);
  control.rest(one(0.02));
  for (int i = 0; i < 100; ++i) control.step(one(5.0), {}, T);
  EXPECT_EQ(control.position()[0], 0.02);
}

TEST(ForceControl, RefusesWrongSizes) {
  EXPECT_THROW(ForceControl({{kGains}, {}}, 2), SceneError);
  EXPECT_THROW(ForceControl({{}, {kAdmittance}}, 2), SceneError);
  EXPECT_THROW(ForceControl({{kGains}, {kAdmittance}}, 1), SceneError);
  EXPECT_FALSE(ForceControlSettings{}.enabled());
}

}  // namespace
}  // namespace haptic::core
