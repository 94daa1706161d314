/// How a contact gives way, from proxies alone.

#include "haptic/client/estimator.hpp"

#include <gtest/gtest.h>

namespace haptic::client {
namespace {

/// A wall at 0 in x[1] of which the proxy goes along with `follows` of the way.
struct Wall {
  double follows{0.75};
  ContactEstimator estimator{{{"x", "m", "linear"}, {"y", "m", "linear"}}, {}};

  Plane at(double depth) {
    const auto contacts = estimator.contacts({0.1, follows * depth}, {0.1, depth});
    EXPECT_EQ(contacts.size(), 1u);
    return contacts.empty() ? Plane{} : contacts.front();
  }
};

TEST(Estimator, FindsTheComplianceOfMotion) {
  Wall wall;
  EXPECT_EQ(wall.at(0.0100).compliance, 0.0) << "nothing is known: rigid, through the proxy";
  EXPECT_EQ(wall.at(0.0102).compliance, 0.0);
  EXPECT_EQ(wall.at(0.0104).compliance, 0.0) << "less than 0.5 mm";
  const Plane contact = wall.at(0.0106);
  EXPECT_NEAR(contact.compliance, 3.0, 1e-9);
  EXPECT_NEAR(contact.offset, 0.0, 1e-12) << "the surface of the object at rest";
  EXPECT_NEAR(contact.normal[1], 1.0, 1e-12);
  EXPECT_EQ(contact.id, 1u);
}

TEST(Estimator, KeepsItWithoutMotion) {
  Wall wall;
  for (int k = 0; k < 4; ++k) static_cast<void>(wall.at(0.010 + 0.001 * k));
  for (int k = 0; k < 20; ++k) EXPECT_NEAR(wall.at(0.013 + 1e-5 * (k % 2)).compliance, 3.0, 1e-9);
  wall.estimator.free();
  EXPECT_NEAR(wall.at(0.002).compliance, 3.0, 1e-9) << "touched again";
  wall.follows = 0.0;
  for (int k = 0; k < 4; ++k) static_cast<void>(wall.at(0.002 + 0.001 * k));
  EXPECT_LT(wall.at(0.006).compliance, 1.0) << "another object";
}

TEST(Estimator, LagsAreLimited) {
  for (const double follows : {1.2, 1.0, -0.5}) {
    Wall wall{.follows = 0.5};
    static_cast<void>(wall.at(0.010));
    for (int k = 1; k < 8; ++k) {
      const double probe = 0.010 + 0.001 * k;
      const auto contacts =
          wall.estimator.contacts({0.1, 0.002 + follows * 0.001 * k}, {0.1, probe});
      ASSERT_EQ(contacts.size(), 1u);
      EXPECT_GE(contacts.front().compliance, 0.0);
      EXPECT_LE(contacts.front().compliance, 9.0 + 1e-9);
    }
  }
}

TEST(Estimator, AnglesNeedTenMilliradians) {
  ContactEstimator estimator({{"q", "rad", "linear"}}, {});
  double compliance = 0.0;
  for (int k = 0; k < 4; ++k) {
    compliance = estimator.contacts({0.05 + 0.001 * k}, {0.1 + 0.002 * k}).front().compliance;
  }
  EXPECT_EQ(compliance, 0.0) << "6 mrad";
  compliance = estimator.contacts({0.056}, {0.112}).front().compliance;
  EXPECT_NEAR(compliance, 1.0, 1e-9);
}

TEST(Estimator, WrongSizesGiveNone) {
  ContactEstimator estimator({{"x", "m", "linear"}}, {});
  EXPECT_TRUE(estimator.contacts({1.0, 2.0}, {3.0}).empty());
  EXPECT_TRUE(estimator.contacts({1.0}, {1.0}).empty()) << "not held";
}

}  // namespace
}  // namespace haptic::client
