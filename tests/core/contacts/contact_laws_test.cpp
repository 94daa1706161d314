#include "haptic/core/contacts/contact_laws.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/core/contacts/told_planes.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

constexpr double kTick = 1e-3;
const ContactLaws::Vector kNone = ContactLaws::Vector::Zero();

PlaneSet::Laws law_of(double mass, double damping, double stiffness, double load) {
  PlaneSet::Laws law(4, 1);
  law << mass, damping, stiffness, load;
  return law;
}

/// Contacts with these laws, which recede at that speed. `ids`, `objects`: if the sample has them.
void tell(ContactLaws& laws, const PlaneSet::Laws& told, double speed, double length = 1.0,
          const PlaneSet::Objects& objects = {}, const PlaneSet::Offsets& ids = {}) {
  PlaneSet set;
  set.laws = told;
  set.velocity.setConstant(told.cols(), speed);
  set.objects = objects;
  set.ids = ids;
  laws.set(set, ContactLaws::Vector::Constant(length), 0);
}

/// A wall at x = 0 that gives way by half and has this law.
PlaneSet pushed(const PlaneSet::Laws& law, double unit = 1.0) {
  PlaneSet set = planes_of(2, 1);
  set.normals(0, 0) = unit;
  set.compliance.setConstant(1, unit * unit);
  set.velocity.setConstant(1, unit * 0.1);
  set.laws = law;
  set.laws.topRows(3) /= unit * unit;
  set.laws.row(3) /= unit;
  return set;
}

TEST(ContactLaws, FreeObjectSwingsAsItShould) {
  ContactLaws laws;
  tell(laws, law_of(0.01, 0.02, 4.0, -0.5), 0.3);
  // s'' + 2 a s' + w^2 s = load / M about the rest at load / k.
  const double a = 1.0, w2 = 400.0, w = std::sqrt(w2 - a * a), rest = -0.5 / 4.0;
  for (int k = 1; k <= 1000; ++k) {
    laws.begin(kTick);
    laws.end(kNone);
    const double t = k * kTick;
    const double s = rest + std::exp(-a * t) *
                                (-rest * std::cos(w * t) + (0.3 - a * rest) / w * std::sin(w * t));
    laws.begin(0.0);
    ASSERT_NEAR(laws.free(0), s, 2e-4) << k;
    laws.end(kNone);
  }
}

TEST(ContactLaws, EveryMassIsStable) {
  const ConfigurationSpace space = line_space(2);
  for (const double mass : {1e-18, 1e-9, 1e-6, 1e-3, 1.0, 1e18}) {
    PlaneProjection projection(space);
    projection.set(pushed(law_of(mass, 0.0, 2.0, 0.0)), two(0, 0));
    for (int k = 0; k < 2000; ++k) {
      const VecX x = led_to(projection, two(0.01, 0), 0.0, kTick);
      ASSERT_TRUE(x.allFinite() && x[0] >= -1e-3 && x[0] <= 0.01) << mass << ", " << k << ": " << x;
    }
  }
}

TEST(ContactLaws, UnitOfTheGapIsFree) {
  const ConfigurationSpace space = line_space(2);
  for (const bool curved : {false, true}) {
    PlaneProjection metres(space), others(space);
    for (const double unit : {1.0, 40.0}) {
      PlaneSet set = pushed(law_of(1e-4, 1e-3, 0.2, -1e-3), unit);
      if (curved) {
        set.curvature = VecX::Constant(3, 2.0 * unit);
        set.curved[0] = 2;
      }
      (unit == 1.0 ? metres : others).set(set, two(0, 0));
    }
    for (int k = 0; k < 300; ++k) {
      const VecX probe = two(0.02 * std::sin(0.03 * k), 0.01);
      const VecX x = led_to(metres, probe, 0.0, kTick);
      ASSERT_NEAR((x - led_to(others, probe, 0.0, kTick)).norm(), 0.0, 1e-12) << k;
    }
    EXPECT_NEAR(metres.stored(), others.stored(), 1e-12);
    EXPECT_GT(metres.stored(), 0.0);
  }
}

/// A body of 0.2 s^2/u^2 that three contacts push: from both sides, and across.
ContactLaws body(double damping, double stiffness) {
  ContactLaws laws;
  PlaneSet::Laws told(4, 3);
  PlaneSet::Objects objects = PlaneSet::Objects::Zero(1 + kMaxMotions, 3);
  for (int i = 0; i < 3; ++i) told.col(i) << 0.2, damping, stiffness, 0.0;
  objects.row(0).setConstant(7.0);
  objects.col(0).segment<2>(1) << -1.0, 0.0;
  objects.col(1).segment<2>(1) << 1.0, 0.0;
  objects.col(2).segment<2>(1) << 0.6, 0.8;
  tell(laws, told, 0.0, 1.0, objects);
  laws.begin(0.0);
  laws.end(kNone);
  return laws;
}

TEST(ContactLaws, PushMovesWholeBody) {
  ContactLaws laws = body(0.0, 0.0);
  ContactLaws::Vector l = kNone;
  l[0] = 0.4;  // from the second tick on 2 u/s^2
  for (int k = 1; k <= 500; ++k) {
    laws.begin(kTick);
    laws.end(l);
  }
  laws.begin(0.0);
  const double s = 0.5 * 2.0 * 0.5 * 0.5;
  EXPECT_NEAR(laws.free(0), s, 1e-3);
  EXPECT_NEAR(laws.free(1), -laws.free(0), 1e-12);
  EXPECT_NEAR(laws.free(2), -0.6 * laws.free(0), 1e-12);
  EXPECT_NEAR(laws.energy(), 0.5 * 0.2 * 1.0, 1e-3) << "once, not per contact";
}

TEST(ContactLaws, OppositePushesCancel) {
  ContactLaws laws = body(0.1, 3.0);
  ContactLaws::Vector l = kNone;
  l[0] = l[1] = 5.0;
  for (int k = 1; k <= 100; ++k) {
    laws.begin(kTick);
    laws.end(l);
    ASSERT_NEAR(laws.free(0), 0.0, 1e-15);
    ASSERT_NEAR(laws.free(2), 0.0, 1e-15);
  }
  EXPECT_NEAR(laws.energy(), 0.0, 1e-25);
}

TEST(ContactLaws, BodyGetsWhatPushesGave) {
  ContactLaws laws = body(0.0, 3.0);
  ContactLaws::Vector l = kNone, last = kNone, before = kNone;
  double given = 0.0, most = 0.0;
  for (int k = 1; k <= 500; ++k) {
    l[0] = std::max(0.0, std::sin(0.05 * k));
    l[1] = std::max(0.0, std::sin(0.03 * k));
    laws.begin(kTick);
    laws.end(l);
    laws.begin(0.0);
    for (int i = 0; i < 2; ++i) {
      given += 0.5 * (l[i] + last[i]) * (laws.free(i) - before[i]);
      before[i] = laws.free(i);
    }
    last = l;
    laws.end(l);
    most = std::max(most, given);
    ASSERT_NEAR(laws.energy(), given, 1e-12) << k;
  }
  EXPECT_GT(most, 1e-3);
}

TEST(ContactLaws, DirectionWithoutLengthSharesNothing) {
  ContactLaws laws;
  PlaneSet::Laws told(4, 2);
  told.setConstant(0.1);
  PlaneSet::Objects objects = PlaneSet::Objects::Zero(1 + kMaxMotions, 2);
  objects.row(0).setConstant(1.0);
  tell(laws, told, 0.0, 1.0, objects);
  laws.begin(kTick);
  EXPECT_EQ(laws.gives(ContactLaws::Vector::Ones()).contacts, 0u);
  EXPECT_GT(laws.give(0), 0.0);
}

TEST(ContactLaws, RewoundObjectIsAsTold) {
  const ConfigurationSpace plane = line_space(2);
  PlaneProjection projection(plane);
  projection.set(pushed(law_of(1e-5, 0.0, 0.0, 0.0)), two(0.0, 0.0));
  EXPECT_NEAR(led_to(projection, two(0.004, 0.0))[0], 0.002, 1e-12) << "gives way by half";
  led_to(projection, two(0.004, 0.0), 0.0, 4.0 * kTick);
  projection.rewind();
  EXPECT_NEAR(led_to(projection, two(0.004, 0.0))[0], 0.002, 1e-12);
}

/// The anchor says what a step of 0 s says at the probe that was used.
TEST(ContactLaws, AnchorSaysWhatPushes) {
  const ConfigurationSpace plane = line_space(2);
  PlaneProjection stepped(plane), begun(plane);
  const VecX used = two(0.004, 0.0), at = two(0.001, 0.0), later = two(0.005, 0.0);
  for (PlaneProjection* each : {&stepped, &begun}) {
    each->set(pushed(law_of(1e-5, 0.0, 0.0, 0.0)), at, &used);
  }
  EXPECT_NEAR(led_to(stepped, used)[0], at[0], 1e-15);
  const VecX x = led_to(stepped, later, 0.0, kTick);
  EXPECT_TRUE(begun.begin_at_anchor());
  for (const char* first : {"begun", "rewound"}) {
    EXPECT_NEAR((x - led_to(begun, later, 0.0, kTick)).norm(), 0.0, 1e-15) << first;
    begun.rewind();
  }
}

/// Contacts 0 and 1 of a body that only its load moves, for 20 ms from rest; then the next sample.
/// The mass of contact 0 that the law goes on with, by the one that is told.
double mass_in_use(double told, double true_mass, double object, double next_id) {
  constexpr double kLoad = 0.03;
  PlaneSet::Laws laws_told = PlaneSet::Laws::Zero(4, 2);
  laws_told.colwise() = Eigen::Vector4d(told, 0.0, 0.0, kLoad);
  PlaneSet::Objects objects = PlaneSet::Objects::Zero(1 + kMaxMotions, 2);
  objects.row(0).setConstant(object);
  objects.row(1).setOnes();
  ContactLaws laws;
  const auto sample = [&](double speed, double id) {
    tell(laws, laws_told, speed, 1.0, objects, two(id, 8.0));
  };
  sample(0.0, 7.0);
  laws.rewind();
  laws.compare_next();
  laws.begin(0.0);
  laws.end(kNone);
  for (int k = 0; k < 20; ++k) {
    laws.begin(kTick);
    laws.end(kNone);
  }
  sample(kLoad * 20 * kTick / true_mass, next_id);
  laws.begin(kTick);
  return 0.25 * kTick * kTick / laws.give(0);  // give = T^2 / (4 M) without D and k
}

TEST(ContactLaws, SpeedsTellTheMass) {
  for (const double told : {0.01, 0.02, 0.04}) {
    EXPECT_NEAR(mass_in_use(told, 0.02, 0.0, 7.0), 0.02, 1e-5) << told;
  }
  EXPECT_NEAR(mass_in_use(1.0, 0.02, 0.0, 7.0), 0.25, 1e-12) << "no more than 4 times";
}

TEST(ContactLaws, NewNamesBeginAsTold) {
  EXPECT_DOUBLE_EQ(mass_in_use(0.04, 0.02, 0.0, 9.0), 0.04);
  EXPECT_DOUBLE_EQ(mass_in_use(0.04, 0.02, 0.0, 0.0), 0.04);
  EXPECT_NEAR(mass_in_use(0.04, 0.02, 3.0, 9.0), 0.02, 1e-5) << "of an object that is known";
}

}  // namespace
}  // namespace haptic::core
