/// Contacts from a simulation's geometry: points of joints, fingers and poses, and what is made of
/// them, against differences of the gap itself.

#include "haptic/client/contact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>

#include "round_trip.hpp"

namespace haptic::client {
namespace {

using std::chrono::milliseconds;
using PointOf = std::function<PointMap(const std::vector<double>& x)>;

/// v turned about a unit axis (Rodrigues).
Vector3 turned(const Vector3& v, const Vector3& a, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double along = (a[0] * v[0] + a[1] * v[1] + a[2] * v[2]) * (1.0 - c);
  return {c * v[0] + s * (a[1] * v[2] - a[2] * v[1]) + along * a[0],
          c * v[1] + s * (a[2] * v[0] - a[0] * v[2]) + along * a[1],
          c * v[2] + s * (a[0] * v[1] - a[1] * v[0]) + along * a[2]};
}
Vector3 plus(const Vector3& a, const Vector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

/// A turntable, a slide on it, and a skew hinge on the slide; the coordinates are x[1] to x[3].
PointMap on_chain(const std::vector<double>& x) {
  const Vector3 up{0, 0, 1}, skew{0.36, 0.48, 0.8};
  const auto turntable = [&](const Vector3& v) { return turned(v, up, x[1]); };
  const Vector3 slide = turntable({1, 0, 0}), hinge = turntable({0.1 + x[2], 0.02, 0.05});
  const Vector3 axis = turntable(skew), arm = turntable(turned({0.03, -0.02, 0.04}, skew, x[3]));
  return point_on_joints({{{0, 0, 0.3}, up, false}, {{}, slide, true}, {hinge, axis, false}},
                         plus(hinge, arm), 1);
}

struct Case {
  const char* name;
  PointOf point;
  std::vector<double> x;
};

std::vector<Case> cases() {
  const auto finger = [](std::size_t phalanx) {
    return [phalanx](const std::vector<double>& x) {
      return point_on_finger({0.045, 0.03, 0.02}, x, phalanx, 0.015, 0.008, 1);
    };
  };
  const double w = std::sqrt(1.0 - 0.01 - 0.04 - 0.09);
  return {{"chain", on_chain, {9.0, 0.4, 0.05, -0.7}},
          {"phalanx 0", finger(0), {9.0, 0.4, 0.8}},
          {"phalanx 2", finger(2), {9.0, 0.4, 0.8, 0.3}},
          {"point", [](const auto& x) { return point_itself(x, 1); }, {9.0, 0.01, 0.02, 0.03}},
          {"pose",
           [](const auto& x) {
             return point_on_pose(x, {0.03, -0.02, 0.05}, 1);
           },
           {9.0, 0.01, 0.02, 0.03, 0.1, -0.2, 0.3, w}}};
}

std::vector<double> moved(std::vector<double> x, std::size_t i, double by) {
  x[i] += by;
  return x;
}

/// d2 f / dx_j dx_k by differences of f.
double mixed(const std::function<double(const std::vector<double>&)>& f,
             const std::vector<double>& x, std::size_t j, std::size_t k) {
  constexpr double h = 1e-4;
  const auto up = moved(x, j, h), down = moved(x, j, -h);
  return (f(moved(up, k, h)) - f(moved(up, k, -h)) - f(moved(down, k, h)) + f(moved(down, k, -h))) /
         (4 * h * h);
}

TEST(PointMap, DerivativesAreItsDifferences) {
  constexpr double h = 1e-5;
  for (const Case& c : cases()) {
    const PointMap map = c.point(c.x);
    const std::size_t n = map.jacobian.size();
    ASSERT_GE(n, 1u);
    for (std::size_t a = 0; a < 3; ++a) {
      const auto p = [&](const std::vector<double>& x) { return c.point(x).position[a]; };
      for (std::size_t j = 0; j < n; ++j) {
        const double slope = (p(moved(c.x, 1 + j, h)) - p(moved(c.x, 1 + j, -h))) / (2 * h);
        EXPECT_NEAR(map.jacobian[j][a], slope, 1e-9) << c.name << ' ' << j;
        for (std::size_t k = 0; k <= j; ++k) {
          const double second = map.second.empty() ? 0.0 : map.second[j * (j + 1) / 2 + k][a];
          EXPECT_NEAR(second, mixed(p, c.x, 1 + j, 1 + k), 1e-7) << c.name << ' ' << j << ' ' << k;
        }
      }
    }
  }
}

TEST(PointMap, AFingersPointsAreComplexNumbers) {
  const std::vector<double> x{0.5, 0.7};
  const std::complex<double> u1 = std::polar(1.0, -0.5), u2 = std::polar(1.0, -1.2);
  const auto p = 0.045 * u1 + (0.03 + std::complex<double>(0.0, -0.008)) * u2;
  const PointMap map = point_on_finger({0.045}, x, 1, 0.03, 0.008);
  EXPECT_NEAR(map.position[0], p.real(), 1e-16);
  EXPECT_NEAR(map.position[1], p.imag(), 1e-16);
  EXPECT_THROW(static_cast<void>(point_on_finger({0.045}, x, 2, 0.0)), std::out_of_range);
}

TEST(PointMap, APoseTurnsItsOffset) {
  const double s = std::sqrt(0.5);  // 90 degrees about z
  const PointMap map = point_on_pose({1, 2, 3, 0, 0, s, s}, {0.1, 0.0, 0.2});
  EXPECT_NEAR(map.position[0], 1.0, 1e-15);
  EXPECT_NEAR(map.position[1], 2.1, 1e-15);
  EXPECT_NEAR(map.position[2], 3.2, 1e-15);
}

/// A ball or a rod of radius 20 mm, against which every point has its gap.
struct Object {
  Vector3 centre{0.06, 0.01, 0.02};
  bool rod{false};
  static constexpr double kRadius = 0.02;

  [[nodiscard]] Contact at(const PointMap& point) const {
    Contact contact{.point = point, .stiffness = 400.0, .velocity = -0.1, .id = 7};
    double distance = 0.0;
    for (std::size_t a = 0; a < 3; ++a) {
      contact.normal[a] = rod && a == 2 ? 0.0 : point.position[a] - centre[a];
      distance = std::hypot(distance, contact.normal[a]);
    }
    for (double& part : contact.normal) part /= distance;
    contact.gap = distance - kRadius;
    contact.curvature = rod ? cylinder_curvature(contact.normal, {0, 0, 1}, distance)
                            : sphere_curvature(contact.normal, distance);
    return contact;
  }
};

TEST(ContactAt, IsTheGapToSecondOrder) {
  constexpr double h = 1e-4;
  for (const bool rod : {false, true}) {
    for (const Case& c : cases()) {
      SCOPED_TRACE(std::string(c.name) + (rod ? ", rod" : ", ball"));
      const Object object{.rod = rod};
      const auto gap = [&](const std::vector<double>& x) { return object.at(c.point(x)).gap; };
      const Plane plane = contact_at(c.x, object.at(c.point(c.x)), 0.02);
      const std::size_t n = c.point(c.x).jacobian.size();
      ASSERT_EQ(plane.normal.size(), c.x.size());
      ASSERT_EQ(plane.curvature.size(), n * (n + 1) / 2);
      EXPECT_EQ(plane.first_coordinate, 1u);
      double told = plane.offset;
      for (std::size_t i = 0; i < c.x.size(); ++i) told -= plane.normal[i] * c.x[i];
      EXPECT_NEAR(told, gap(c.x), 1e-15);
      EXPECT_EQ(plane.normal[0], 0.0);
      for (std::size_t j = 0; j < n; ++j) {
        const auto up = moved(c.x, 1 + j, h), down = moved(c.x, 1 + j, -h);
        EXPECT_NEAR(-plane.normal[1 + j], (gap(up) - gap(down)) / (2 * h), 1e-6);
        for (std::size_t k = 0; k <= j; ++k) {
          EXPECT_NEAR(plane.curvature[j * (j + 1) / 2 + k], mixed(gap, c.x, 1 + j, 1 + k), 1e-3)
              << j << ' ' << k;
        }
      }
    }
  }
}

TEST(ContactAt, CarriesWhatItWasTold) {
  Contact contact = Object{}.at(point_itself({0.0, 0.0, 0.0}));
  Plane plane = contact_at({0.0, 0.0, 0.0}, contact, 1500.0);
  EXPECT_EQ(plane.compliance, 3.75);
  EXPECT_EQ(plane.velocity, -0.1);
  EXPECT_EQ(plane.id, 7u);
  EXPECT_EQ(plane.mass, 0.0);
  contact.mass = 0.75;
  contact.damping = 3.0;
  contact.ground_stiffness = 375.0;
  contact.load = -1.5;
  plane = contact_at({0.0, 0.0, 0.0}, contact, 1500.0);
  EXPECT_EQ(plane.mass, 0.0005);
  EXPECT_EQ(plane.damping, 0.002);
  EXPECT_EQ(plane.ground_stiffness, 0.25);
  EXPECT_EQ(plane.load, -0.001);
  EXPECT_TRUE(plane.object_direction.empty()) << "the only one on its object";
  contact.object = 4;
  plane = contact_at({0.0, 0.0, 0.0}, contact, 1500.0);
  EXPECT_EQ(plane.object, 4u);
  EXPECT_EQ(plane.object_direction,
            std::vector<double>(contact.normal.begin(), contact.normal.end()));
  contact.object_direction = {0.0, 1.0};
  plane = contact_at({0.0, 0.0, 0.0}, contact, 1500.0);
  EXPECT_EQ(plane.object_direction, std::vector<double>({0.0, 1.0}));
  contact.stiffness = Contact{}.stiffness;
  contact.curvature = {};
  plane = contact_at({0.0, 0.0, 0.0}, contact, 1500.0);
  EXPECT_EQ(plane.compliance, 0.0) << "rigid";
  EXPECT_TRUE(plane.curvature.empty()) << "flat against a point that moves straight";
}

TEST(ContactAt, RefusesCoordinatesBeyondX) {
  Contact contact{.point = point_itself({0.0, 0.0, 0.0, 0.0}, 1), .normal = {1.0, 0.0, 0.0}};
  const auto refusal = [&](const std::vector<double>& x) -> std::string {
    try {
      static_cast<void>(contact_at(x, contact, 1500.0));
    } catch (const std::out_of_range& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({0, 0, 0, 0}), "");
  EXPECT_EQ(refusal({0, 0, 0}),
            "point.first_coordinate 1, 3 coordinates: must lie within the 3 of x");
  contact.point.first_coordinate = 9;
  EXPECT_NE(refusal({0, 0, 0, 0}), "");
  contact.point.first_coordinate = 1;
  contact.point.second.resize(5);
  EXPECT_EQ(refusal({0, 0, 0, 0}),
            "point.second: has 5 vectors, must have 0 or 6 for 3 coordinates");
}

TEST(ContactHorizon, IsHowFarAPointGets) {
  EXPECT_NEAR(contact_horizon(milliseconds(100), milliseconds(20), 0.3), 0.036, 1e-15);
  EXPECT_NEAR(contact_horizon({}, milliseconds(0), 0.5), 0.1, 1e-15) << "not known yet";
}

TEST(RoundTripTime, RisesAtOnceFallsSlowly) {
  RoundTrip trip;
  const RoundTrip::TimePoint begin{};
  trip.used(1, begin);
  EXPECT_EQ(trip.value().count(), 0) << "nothing was published";
  const auto takes = [&](std::uint64_t seq, milliseconds time) {
    trip.published(seq, begin);
    trip.used(seq, begin + time);
    trip.used(seq, begin + 2 * time);  // a later state with the same sample
    return trip.value();
  };
  EXPECT_EQ(takes(2, milliseconds(16)), milliseconds(16));
  EXPECT_EQ(takes(3, milliseconds(48)), milliseconds(48));
  EXPECT_EQ(takes(4, milliseconds(16)), milliseconds(46));
}

}  // namespace
}  // namespace haptic::client
