// Contacts: planes with a compliance, a velocity, a curvature and an anchor
// (core/METHOD.md#contacts).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/core/contacts/told_planes.hpp"
#include "tests/support/dense_oracle.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

PlaneSet soft_wall(double offset, double gamma) {
  PlaneSet set = planes_of(2, 1);
  set.normals(0, 0) = 1.0;
  set.offsets[0] = offset;
  set.compliance = one(gamma);
  return set;
}

/// The disc of radius `radius` around `centre`, seen from where x is: gap, gradient and second
/// derivative of the distance.
PlaneSet disc(const VecX& centre, double radius, const VecX& x, double gamma) {
  const VecX out = (x - centre).normalized();
  const double distance = (x - centre).norm();
  PlaneSet set = planes_of(2, 1);
  set.normals.col(0) = -out;
  set.offsets[0] = distance - radius - out.dot(x);
  set.compliance = one(gamma);
  set.curvature.resize(3);
  set.curvature << (1.0 - out[0] * out[0]) / distance, -out[0] * out[1] / distance,
      (1.0 - out[1] * out[1]) / distance;
  set.curved[0] = 2;
  return set;
}

TEST(ContactProjection, OneContactHasItsClosedForm) {
  // 3 x + 4 y <= 5 from (3, 4), which is 4 beyond in units of length and 20 in units of the gap:
  // l = 20 / (25 + gamma), x = p - n l.
  PlaneSet set = planes_of(2, 1);
  set.normals.col(0) = two(3, 4);
  set.offsets[0] = 5.0;
  set.compliance = one(50.0);
  const ConfigurationSpace space = line_space(2);
  PlaneProjection projection(space);
  projection.set(set, two(0.3, 0.1));
  VecX x;
  EXPECT_EQ(projection.project(two(3, 4), x), PlaneStatus::kActive);
  EXPECT_NEAR(x[0], 3.0 - 3.0 * 20.0 / 75.0, 1e-13);
  EXPECT_NEAR(x[1], 4.0 - 4.0 * 20.0 / 75.0, 1e-13);
  // Energy: the contact's -phi = gamma l = 40/3, phi^2 / gamma = 32/9; the coupling's (4/3)^2.
  EXPECT_NEAR(projection.stored(), 2.0 * projection.coupling(), 1e-13);
  EXPECT_EQ(projection.project(two(0, 0), x), PlaneStatus::kFree);
  EXPECT_EQ(projection.stored(), 0.0);
}

TEST(ContactProjection, NoLawIsAPlane) {
  std::mt19937 random(31);
  std::normal_distribution<double> normal(0.0, 1.0);
  const ConfigurationSpace space = line_space(4);
  for (int n = 0; n < 500; ++n) {
    PlaneSet plain = planes_of(4, 6);
    fill(plain.normals, [&] { return normal(random); });
    fill(plain.offsets, [&] { return 0.2 * normal(random); });
    PlaneSet zeros = plain;
    zeros.compliance = zeros.velocity = PlaneSet::Offsets::Zero(6);
    zeros.curvature.setZero(60);
    std::fill_n(zeros.curved.begin(), 6, std::uint8_t{4});
    PlaneProjection a(space), b(space);
    const VecX at = VecX::Constant(4, 0.3);
    a.set(plain, at);
    b.set(zeros, at);
    VecX probe(4), x_a, x_b;
    fill(probe, [&] { return normal(random); });
    ASSERT_EQ(a.project(probe, x_a), b.project(probe, x_b, 0.1));
    ASSERT_EQ(x_a, x_b);
  }
}

/// The conditions of the minimum, which are sufficient: W (p - x) = sum n_i l_i with l_i >= 0. Only
/// contacts that hold x have an l_i. Of a soft contact it is its spring's force.
void expect_minimum(const PlaneSet& set, const VecX& probe, const Eigen::MatrixXd& W,
                    const VecX& x) {
  const double size = 1.0 + (probe - x).norm();
  Eigen::VectorXd rest = W * Eigen::VectorXd(probe - x);
  std::vector<int> rigid;
  for (int i = 0; i < set.size(); ++i) {
    const double beyond = set.normals.col(i).dot(x) - set.offsets[i];
    if (set.compliance[i] > 0.0) {
      rest -= std::max(0.0, beyond) / set.compliance[i] * Eigen::VectorXd(set.normals.col(i));
    } else {
      ASSERT_LE(beyond, 1e-8 * size);
      if (beyond > -1e-8 * size) rigid.push_back(i);
    }
  }
  const double most = 1e-6 * W.norm() * size;
  if (!rigid.empty()) {
    const Eigen::MatrixXd N = Eigen::MatrixXd(set.normals)(Eigen::all, rigid);
    const Eigen::VectorXd l = oracle::least_squares(N, rest);
    ASSERT_GE(l.minCoeff(), -most);
    rest -= N * l;
  }
  ASSERT_LE(rest.norm(), most);
}

/// Planes that can be met (every third run), and contacts, under any metric.
TEST(ContactProjection, IsTheMinimum) {
  std::mt19937 random(32);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::uniform_real_distribution<double> decade(-3.0, 2.0), weight(0.2, 5.0);
  int held[2]{}, pinched = 0;
  for (int n = 0; n < 6000; ++n) {
    const bool planes = n % 3 == 0;
    const int n_x = 2 + n % 4, p = 1 + n % (planes ? 6 : 32);
    Eigen::MatrixXd W = Eigen::MatrixXd::Identity(n_x, n_x), B(n_x, n_x);
    if (n % 2 == 1) {
      for (double& entry : W.diagonal()) entry = weight(random);
      for (double& entry : B.reshaped()) entry = n % 4 == 1 ? normal(random) : 0.0;
      W += oracle::product(B, B.transpose());
    }
    VecX probe(n_x), inside(n_x), x;
    fill(probe, [&] { return 2.0 * normal(random); });
    fill(inside, [&] { return normal(random); });
    PlaneSet set = planes_of(n_x, p);
    set.compliance.setZero(p);
    for (int i = 0; i < p; ++i) {
      for (int j = 0; j < n_x; ++j) set.normals(j, i) = normal(random);
      set.offsets[i] = normal(random);
      if (planes) set.offsets[i] = set.normals.col(i).dot(inside) + std::abs(set.offsets[i]);
      // Rigid ones can always be met if they are fewer than coordinates.
      if (planes || (i < n_x - 1 && n % 3 == 1)) continue;
      set.compliance[i] = std::pow(10.0, decade(random));
      if (i > 0 && n % 5 == 0) {  // pinches with the one before
        set.normals.col(i) = -set.normals.col(i - 1);
        set.offsets[i] = -set.offsets[i - 1] - 0.5;
        ++pinched;
      }
    }
    const ConfigurationSpace space = line_space(n_x);
    PlaneProjection projection(space, TaskMetric::from_matrix(W));
    projection.set(set, VecX::Constant(n_x, 0.3));
    ASSERT_NE(projection.project(probe, x), PlaneStatus::kInfeasible) << n;
    ASSERT_NO_FATAL_FAILURE(expect_minimum(set, probe, W, x)) << n;
    held[planes ? 1 : 0] += projection.active() != 0 ? 1 : 0;
  }
  EXPECT_GT(held[0], 2000);
  EXPECT_GT(held[1], 500);
  EXPECT_GT(pinched, 500);
}

TEST(ContactProjection, VelocityMovesTheSurface) {
  PlaneSet set = soft_wall(0.1, 0.0);
  set.velocity = one(-0.5);
  const ConfigurationSpace space = line_space(2);
  PlaneProjection projection(space);
  projection.set(set, two(0, 0));
  VecX x;
  EXPECT_NEAR(led_to(projection, two(1, 0), 0.04)[0], 0.08, 1e-14);
  EXPECT_EQ(projection.project(two(0.09, 0), x, 0.0), PlaneStatus::kFree);
  EXPECT_EQ(projection.project(two(0.09, 0), x, 0.04), PlaneStatus::kActive);
}

/// The quadratic gap, minimised by Newton's method with the exact Hessian.
VecX on_quadratic(const PlaneSet& set, const VecX& at, const VecX& probe) {
  Eigen::Matrix2d H;
  H << set.curvature[0], set.curvature[1], set.curvature[1], set.curvature[2];
  Eigen::Vector2d x = at;
  for (int n = 0; n < 100; ++n) {
    const Eigen::Vector2d z = x - at;
    const double phi = set.offsets[0] - set.normals.col(0).dot(x) + 0.5 * z.dot(H * z);
    const Eigen::Vector2d g = -set.normals.col(0) + H * z;
    if (phi >= 0.0) return x;
    const double k = 1.0 / set.compliance[0];
    const Eigen::Vector2d slope = (x - probe) + k * phi * g;
    const Eigen::Matrix2d B = Eigen::Matrix2d::Identity() + k * (g * g.transpose() + phi * H);
    const Eigen::Vector2d step = oracle::product(oracle::inverse(B), slope);
    x -= step;
    if (step.norm() < 1e-15) break;
  }
  return x;
}

/// A probe 6 mm deep in a disc of 30 mm, 1500 N/m of coupling on 500 N/m, strokes it with
/// `speed` m/s under samples of 60 Hz that are `late` ticks old: largest error, m, against the
/// exact answer of the quadratic gap.
double stroke(double speed, int late) {
  const VecX centre = two(0, 0);
  const double radius = 0.030, gamma = 3.0;
  const auto probe = [&](int tick) {
    const double phi = speed * tick * 1e-3 / radius;
    return VecX((radius - 0.006) * two(std::cos(phi), std::sin(phi)));
  };
  const ConfigurationSpace space = line_space(2);
  PlaneProjection projection(space);
  PlaneSet set;
  VecX at;
  double worst = 0.0;
  for (int tick = 0; tick < 200; ++tick) {
    if (tick % 16 == 0) {
      const VecX seen = probe(tick - late);
      at = seen * (1.0 + 0.006 / (1.0 + gamma) / seen.norm());  // the client's own proxy
      set = disc(centre, radius, at, gamma);
      projection.set(set, at);
    }
    const VecX x = led_to(projection, probe(tick));
    worst = std::max(worst, (x - on_quadratic(set, at, probe(tick))).norm());
  }
  return worst;
}

TEST(ContactProjection, TwoStepsFollowAStroke) {
  EXPECT_LT(stroke(0.07, 0), 4e-7);
  EXPECT_LT(stroke(0.07, 100), 4e-7);
  EXPECT_LT(stroke(0.5, 20), 4e-6);
}

TEST(ContactProjection, CurvedRigidWallIsMet) {
  const VecX at = two(0.03, 0);
  PlaneSet set = disc(two(0, 0), 0.03, at, 0.0);
  const ConfigurationSpace space = line_space(2);
  PlaneProjection projection(space);
  projection.set(set, at);
  VecX x;
  const VecX probe = two(0.024, 0.008);
  EXPECT_EQ(projection.project(probe, x), PlaneStatus::kActive);
  const double phi = x[0] - 0.03 + x[1] * x[1] / 0.06;  // of the quadratic gap
  EXPECT_NEAR(phi, 0.0, 1e-9);
  // x - probe is along the gradient (1, y / R)
  EXPECT_NEAR((x[1] - probe[1]) - (x[0] - probe[0]) * x[1] / 0.03, 0.0, 1e-8);
}

TEST(ContactProjection, CurvatureCannotTurnANormalAway) {
  std::mt19937 random(33);
  std::normal_distribution<double> normal(0.0, 1.0);
  const ConfigurationSpace space = line_space(3);
  for (int n = 0; n < 2000; ++n) {
    PlaneSet set = planes_of(3, 5);
    fill(set.normals, [&] { return normal(random); });
    fill(set.offsets, [&] { return 0.1 * normal(random); });
    set.compliance = PlaneSet::Offsets::Constant(5, n % 2 == 0 ? 0.0 : 0.3);
    set.curvature.resize(30);
    fill(set.curvature, [&] { return std::pow(10.0, n % 12) * normal(random); });
    std::fill_n(set.curved.begin(), 5, std::uint8_t{3});
    PlaneProjection projection(space);
    projection.set(set, VecX::Zero(3));
    VecX probe(3);
    for (int tick = 0; tick < 4; ++tick) {
      fill(probe, [&] { return normal(random); });
      ASSERT_LT(led_to(projection, probe).norm(), 1e4) << n;
    }
  }
}

class AnchorTest : public ::testing::Test {
 protected:
  VecX law(const PlaneSet& set, const VecX& at, const VecX* used, const VecX& probe) {
    projection_.set(set, at, used);
    return led_to(projection_, probe);
  }
  const ConfigurationSpace space_ = line_space(2);
  PlaneProjection projection_{space_};
};

TEST_F(AnchorTest, LawGivesTheClientsProxy) {
  // A wall told to be at 0 with gamma 3; the client's own proxy gave way less than that.
  const VecX used = two(0.010, 0.2), proxy = two(0.006, 0.2);
  EXPECT_GT((law(soft_wall(0.0, 3.0), proxy, nullptr, used) - proxy).norm(), 1e-3);
  EXPECT_NEAR((law(soft_wall(0.0, 3.0), proxy, &used, used) - proxy).norm(), 0.0, 1e-9);
  EXPECT_NEAR(projection_.unexplained(), 0.0, 1e-9);
  // From there on with the told compliance: x follows by 3/4 of the way.
  EXPECT_NEAR(led_to(projection_, two(0.014, 0.2))[0], 0.006 + 0.75 * 0.004, 1e-9);
}

TEST_F(AnchorTest, ReportsWhatNoContactExplains) {
  // The client's proxy is 4 mm back along the normal and 3 mm along the surface.
  const VecX used = two(0.010, 0.003), proxy = two(0.006, 0.0);
  const VecX x = law(soft_wall(0.0, 3.0), proxy, &used, used);
  EXPECT_NEAR(projection_.unexplained(), 0.003, 1e-9);
  EXPECT_NEAR((x - two(0.006, 0.003)).norm(), 0.0, 1e-9);
  // In free space nothing is left of it: it is no constant force.
  EXPECT_EQ(law(soft_wall(0.0, 3.0), proxy, &used, two(-0.01, 0.5)), two(-0.01, 0.5));
}

TEST_F(AnchorTest, ManyContactsShiftTheLeast) {
  // Twelve contacts in two coordinates around the client's exact answer, told 0.1 mm wrong at most:
  // the law gives its proxy, and no surface moves by more than a few of these.
  std::mt19937 random(34);
  std::uniform_real_distribution<double> sideways(-1.0, 1.0), wrong(-1e-4, 1e-4);
  for (int n = 0; n < 300; ++n) {
    PlaneSet truth = planes_of(2, 12);
    truth.compliance = PlaneSet::Offsets::Constant(12, 2.0);
    for (int i = 0; i < 12; ++i) {
      truth.normals.col(i) = two(1.0, sideways(random)).normalized();
      truth.offsets[i] = 0.002 * sideways(random);
    }
    const VecX used = two(0.010, 0.001);
    const VecX proxy = law(truth, two(0, 0), nullptr, used);
    PlaneSet told = truth;
    for (double& offset : told.offsets) offset += wrong(random);
    ASSERT_NEAR((law(told, proxy, &used, used) - proxy).norm(), 0.0, 2e-7) << n;
    const VecX later = two(0.012, 0.000);
    const VecX x = led_to(projection_, later);
    ASSERT_NEAR((x - law(truth, two(0, 0), nullptr, later)).norm(), 0.0, 1e-4) << n;
  }
}

TEST_F(AnchorTest, ManyLeaveARightLawAlone) {
  // Twelve pads of a finger: metres by radians, N m/rad by N/m. Any units give the same law.
  std::mt19937 random(36);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  for (const double unit : {1e-3, 1.0, 1e3}) {
    for (int n = 0; n < 100; ++n) {
      PlaneSet truth = planes_of(2, 12);
      truth.compliance = PlaneSet::Offsets::Constant(12, 0.02 / 400.0 * unit * unit);
      for (int i = 0; i < 12; ++i) {
        truth.normals.col(i) = unit * two(0.05 * part(random), 0.03 * part(random));
        truth.offsets[i] = unit * 0.003 * (part(random) - 0.5);
      }
      const VecX used = two(0.15, 0.10), later = two(0.19, 0.08);
      const VecX proxy = law(truth, two(0, 0), nullptr, used);
      const VecX right = law(truth, two(0, 0), nullptr, later);
      ASSERT_GT((right - later).norm(), 0.01);
      ASSERT_NEAR((law(truth, proxy, &used, later) - right).norm(), 0.0, 1e-7) << unit << ' ' << n;
      // A solver that stops short by 1e-5 rad brings no open contact, with its gap, into the law.
      const VecX rest = proxy + 1e-5 * two(part(random) - 0.5, 1.0);
      ASSERT_NEAR((law(truth, rest, &used, later) - right).norm(), 0.0, 2e-4) << unit << ' ' << n;
    }
  }
}

TEST(ContactProjection, WrongNumbersLeaveTheContactOut) {
  const struct {
    const char* what;
    void (*spoil)(PlaneSet&);
    bool fits;
  } cases[] = {{"compliance", [](PlaneSet& set) { set.compliance[0] = kNan; }, false},
               {"compliance < 0", [](PlaneSet& set) { set.compliance[0] = -1.0; }, true},
               {"velocity", [](PlaneSet& set) { set.velocity[0] = kNan; }, false},
               {"curvature", [](PlaneSet& set) { set.curvature[1] = kNan; }, false},
               {"normal", [](PlaneSet& set) { set.normals(0, 0) = kNan; }, false},
               {"load", [](PlaneSet& set) { set.laws(PlaneSet::kLoad, 0) = kNan; }, false}};
  const ConfigurationSpace space = line_space(2);
  for (const auto& c : cases) {
    PlaneSet set = soft_wall(0.0, 1.0);
    set.velocity = one(0.0);
    set.curvature.setZero(3);
    set.curved[0] = 2;
    set.laws.setOnes(4, 1);
    c.spoil(set);
    PlaneProjection projection(space);
    projection.set(set, two(0, 0));
    VecX x;
    EXPECT_EQ(projection.project(two(1, 0), x), PlaneStatus::kFree) << c.what;
    EXPECT_EQ(x, two(1, 0)) << c.what;
    EXPECT_EQ(set.fits(2), c.fits) << c.what;
  }
}

}  // namespace
}  // namespace haptic::core
