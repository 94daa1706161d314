// Contacts: planes with a compliance, a velocity, a curvature and an anchor
// (core/METHOD.md#contacts).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "haptic/core/contacts/plane_projection.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/dense_oracle.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

ConfigurationSpace line_space(int n_x) {
  return ConfigurationSpace(std::vector<Coordinate>(static_cast<std::size_t>(n_x)));
}

/// `count` contacts without a law, normals and offsets 0.
PlaneSet contacts_of(int n_x, int count) {
  PlaneSet set;
  set.normals.setZero(n_x, count);
  set.offsets.setZero(count);
  return set;
}

PlaneSet soft_wall(double offset, double gamma) {
  PlaneSet set = contacts_of(2, 1);
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
  PlaneSet set = contacts_of(2, 1);
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
  PlaneSet set = contacts_of(2, 1);
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

TEST(ContactProjection, ComplianceIsInTheMetricsUnits) {
  // W = 4: the coupling is four times as stiff, so x gives way by 1 / (1 + 4 gamma) of the depth.
  const ConfigurationSpace space = line_space(2);
  PlaneProjection projection(space, TaskMetric::from_scales(two(0.5, 0.5)));
  projection.set(soft_wall(0.0, 0.75), two(0, 0));
  VecX x;
  static_cast<void>(projection.project(two(0.8, 5), x));
  EXPECT_NEAR(x[0], 0.8 * (1.0 - 1.0 / (1.0 + 4.0 * 0.75)), 1e-14);
  EXPECT_EQ(x[1], 5.0);
}

TEST(ContactProjection, NoLawIsAPlane) {
  std::mt19937 random(31);
  std::normal_distribution<double> normal(0.0, 1.0);
  const ConfigurationSpace space = line_space(4);
  for (int n = 0; n < 500; ++n) {
    PlaneSet plain = contacts_of(4, 6);
    for (double& entry : plain.normals.reshaped()) entry = normal(random);
    for (double& entry : plain.offsets.reshaped()) entry = 0.2 * normal(random);
    PlaneSet zeros = plain;
    zeros.compliance = zeros.velocity = PlaneSet::Offsets::Zero(6);
    zeros.curvature.setZero(60);
    std::fill_n(zeros.curved.begin(), 6, std::uint8_t{4});
    PlaneProjection a(space), b(space);
    const VecX at = VecX::Constant(4, 0.3);
    a.set(plain, at);
    b.set(zeros, at);
    VecX probe(4), x_a, x_b;
    for (double& entry : probe.reshaped()) entry = normal(random);
    ASSERT_EQ(a.project(probe, x_a), b.project(probe, x_b, 0.1));
    ASSERT_EQ(x_a, x_b);
  }
}

/// l by trying every subset of contacts as the active one.
bool every_subset(const PlaneSet& set, const VecX& probe, const Eigen::MatrixXd& W, VecX& x) {
  const int p = set.size();
  const Eigen::MatrixXd D = oracle::product(oracle::inverse(W), Eigen::MatrixXd(set.normals));
  const Eigen::MatrixXd G = oracle::product(Eigen::MatrixXd(set.normals.transpose()), D);
  const Eigen::VectorXd r = set.normals.transpose() * probe - set.offsets;
  for (int mask = 0; mask < 1 << p; ++mask) {
    std::vector<int> held;
    for (int i = 0; i < p; ++i) {
      if ((mask >> i & 1) != 0) held.push_back(i);
    }
    const auto n = static_cast<Eigen::Index>(held.size());
    Eigen::VectorXd l = Eigen::VectorXd::Zero(p);
    if (n > 0) {
      Eigen::MatrixXd M(n, n), v(n, 1);
      for (Eigen::Index i = 0; i < n; ++i) {
        const int a = held[static_cast<std::size_t>(i)];
        for (Eigen::Index j = 0; j < n; ++j) M(i, j) = G(a, held[static_cast<std::size_t>(j)]);
        M(i, i) += set.compliance[a];
        v(i, 0) = r[a];
      }
      if (std::abs(oracle::determinant(M)) < 1e-12) continue;
      const Eigen::MatrixXd s = oracle::product(oracle::inverse(M), v);
      if (s.minCoeff() < 0.0) continue;
      for (Eigen::Index i = 0; i < n; ++i) l[held[static_cast<std::size_t>(i)]] = s(i, 0);
    }
    const Eigen::VectorXd left = r - G * l - set.compliance.cwiseProduct(l);
    if (left.maxCoeff() > 1e-9) continue;
    x = probe - D * l;
    return true;
  }
  return false;
}

/// Planes that can be met (every third run), and contacts, under any metric.
TEST(ContactProjection, AgreesWithEverySubset) {
  std::mt19937 random(32);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::uniform_real_distribution<double> decade(-3.0, 2.0), weight(0.2, 5.0);
  int held[2]{}, pinched = 0;
  for (int n = 0; n < 6000; ++n) {
    const bool planes = n % 3 == 0;
    const int n_x = 2 + n % 4, p = 1 + n % (planes ? 6 : 8);
    Eigen::MatrixXd W = Eigen::MatrixXd::Identity(n_x, n_x), B(n_x, n_x);
    if (n % 2 == 1) {
      for (double& entry : W.diagonal()) entry = weight(random);
      for (double& entry : B.reshaped()) entry = n % 4 == 1 ? normal(random) : 0.0;
      W += oracle::product(B, B.transpose());
    }
    VecX probe(n_x), inside(n_x), expected, x;
    for (double& entry : probe.reshaped()) entry = 2.0 * normal(random);
    for (double& entry : inside.reshaped()) entry = normal(random);
    PlaneSet set = contacts_of(n_x, p);
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
    ASSERT_TRUE(every_subset(set, probe, W, expected)) << n;
    const ConfigurationSpace space = line_space(n_x);
    PlaneProjection projection(space, TaskMetric::from_matrix(W));
    projection.set(set, VecX::Constant(n_x, 0.3));
    ASSERT_NE(projection.project(probe, x), PlaneStatus::kInfeasible) << n;
    ASSERT_NEAR((x - expected).norm(), 0.0, 1e-8 * (1.0 + (expected - probe).norm())) << n;
    held[planes ? 1 : 0] += projection.active() != 0 ? 1 : 0;
  }
  EXPECT_GT(held[0], 2000);
  EXPECT_GT(held[1], 500);
  EXPECT_GT(pinched, 500);
}

TEST(ContactProjection, SoftPinchSharesByStiffness) {
  // x <= 0 with gamma 1, x >= 1 with gamma 3, and the coupling's 1 from the probe: minimise
  // x^2 / 1 + (1 - x)^2 / 3 + (x - 0.4)^2.
  PlaneSet set = contacts_of(1, 2);
  set.normals << 1, -1;
  set.offsets << 0, -1;
  set.compliance = two(1, 3);
  const ConfigurationSpace space = line_space(1);
  PlaneProjection projection(space);
  projection.set(set, one(0.0));
  VecX x;
  EXPECT_EQ(projection.project(one(0.4), x), PlaneStatus::kActive);
  EXPECT_NEAR(x[0], (1.0 / 3.0 + 0.4) / (1.0 + 1.0 / 3.0 + 1.0), 1e-13);
}

TEST(ContactProjection, VelocityMovesTheSurface) {
  PlaneSet set = soft_wall(0.1, 0.0);
  set.velocity = one(-0.5);
  const ConfigurationSpace space = line_space(2);
  PlaneProjection projection(space);
  projection.set(set, two(0, 0));
  VecX x;
  static_cast<void>(projection.project(two(1, 0), x, 0.04));
  EXPECT_NEAR(x[0], 0.08, 1e-14);
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
  VecX at, x;
  double worst = 0.0;
  for (int tick = 0; tick < 200; ++tick) {
    if (tick % 16 == 0) {
      const VecX seen = probe(tick - late);
      at = seen * (1.0 + 0.006 / (1.0 + gamma) / seen.norm());  // the client's own proxy
      set = disc(centre, radius, at, gamma);
      projection.set(set, at);
    }
    static_cast<void>(projection.project(probe(tick), x));
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
    PlaneSet set = contacts_of(3, 5);
    for (double& entry : set.normals.reshaped()) entry = normal(random);
    for (double& entry : set.offsets.reshaped()) entry = 0.1 * normal(random);
    set.compliance = PlaneSet::Offsets::Constant(5, n % 2 == 0 ? 0.0 : 0.3);
    set.curvature.resize(30);
    for (double& entry : set.curvature.reshaped()) entry = std::pow(10.0, n % 12) * normal(random);
    std::fill_n(set.curved.begin(), 5, std::uint8_t{3});
    PlaneProjection projection(space);
    projection.set(set, VecX::Zero(3));
    VecX probe(3), x;
    for (int tick = 0; tick < 4; ++tick) {
      for (double& entry : probe.reshaped()) entry = normal(random);
      static_cast<void>(projection.project(probe, x));
      ASSERT_TRUE(x.allFinite()) << n;
      ASSERT_LT(x.norm(), 1e4) << n;
    }
  }
}

class AnchorTest : public ::testing::Test {
 protected:
  VecX law(const PlaneSet& set, const VecX& at, const VecX* used, const VecX& probe) {
    projection_.set(set, at, used);
    VecX x;
    static_cast<void>(projection_.project(probe, x));
    return x;
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
  VecX x;
  static_cast<void>(projection_.project(two(0.014, 0.2), x));
  EXPECT_NEAR(x[0], 0.006 + 0.75 * 0.004, 1e-9);
}

TEST_F(AnchorTest, RightLawIsLeftAlone) {
  const VecX used = two(0.012, 0.2), proxy = two(0.009, 0.2);
  for (const double probe : {-0.01, 0.001, 0.02}) {
    const VecX at = two(probe, 0.1);
    EXPECT_NEAR(
        (law(soft_wall(0.0, 3.0), proxy, &used, at) - law(soft_wall(0.0, 3.0), proxy, nullptr, at))
            .norm(),
        0.0, 1e-9);
  }
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

TEST_F(AnchorTest, ClientThatTouchesNothingIsFree) {
  const VecX used = two(0.010, 0.2);
  EXPECT_EQ(law(soft_wall(0.0, 3.0), used, &used, used), used);
  EXPECT_EQ(law(soft_wall(0.0, 0.0), used, &used, two(0.009, 0.2)), two(0.009, 0.2));
}

TEST_F(AnchorTest, ManyContactsShiftTheLeast) {
  // Twelve contacts in two coordinates around the client's exact answer, told 0.1 mm wrong at most:
  // the law gives its proxy, and no surface moves by more than a few of these.
  std::mt19937 random(34);
  std::uniform_real_distribution<double> sideways(-1.0, 1.0), wrong(-1e-4, 1e-4);
  for (int n = 0; n < 300; ++n) {
    PlaneSet truth = contacts_of(2, 12);
    truth.compliance = PlaneSet::Offsets::Constant(12, 2.0);
    for (int i = 0; i < 12; ++i) {
      truth.normals.col(i) = two(1.0, sideways(random)).normalized();
      truth.offsets[i] = 0.002 * sideways(random);
    }
    const VecX used = two(0.010, 0.001);
    const VecX proxy = law(truth, two(0, 0), nullptr, used);
    PlaneSet told = truth;
    for (double& entry : told.offsets.reshaped()) entry += wrong(random);
    ASSERT_NEAR((law(told, proxy, &used, used) - proxy).norm(), 0.0, 2e-7) << n;
    const VecX later = two(0.012, 0.000);
    VecX x;
    static_cast<void>(projection_.project(later, x));
    ASSERT_NEAR((x - law(truth, two(0, 0), nullptr, later)).norm(), 0.0, 1e-4) << n;
  }
}

TEST_F(AnchorTest, ManyLeaveARightLawAlone) {
  // Twelve pads of a finger: metres by radians, N m/rad by N/m. Any units give the same law.
  std::mt19937 random(36);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  for (const double unit : {1e-3, 1.0, 1e3}) {
    for (int n = 0; n < 100; ++n) {
      PlaneSet truth = contacts_of(2, 12);
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
  const ConfigurationSpace space = line_space(2);
  for (int what = 0; what < 6; ++what) {
    PlaneSet set = soft_wall(0.0, 1.0);
    set.velocity = one(0.0);
    set.curvature.setZero(3);
    set.curved[0] = 2;
    set.laws.setOnes(4, 1);
    (what == 0   ? set.compliance[0]
     : what == 1 ? set.velocity[0]
     : what == 2 ? set.curvature[1]
     : what == 3 ? set.normals(0, 0)
     : what == 5 ? set.laws(PlaneSet::kLoad, 0)
                 : set.compliance[0]) = what == 4 ? -1.0 : kNan;
    PlaneProjection projection(space);
    projection.set(set, two(0, 0));
    VecX x;
    EXPECT_EQ(projection.project(two(1, 0), x), PlaneStatus::kFree) << what;
    EXPECT_EQ(x, two(1, 0)) << what;
    EXPECT_EQ(set.fits(2), what == 4) << what;
  }
}

TEST(ContactProjection, AllocatesNothing) {
  const VecX at = two(0.03, 0), used = two(0.02, 0.001);
  PlaneSet set = disc(two(0, 0), 0.03, at, 1.0);
  set.laws.setOnes(4, 1);
  const ConfigurationSpace space = line_space(2);
  PlaneProjection projection(space);
  VecX x(2);
  projection.set(set, at, &used);
  const haptic::test::AllocationGuard guard;
  projection.set(set, at, &used);
  static_cast<void>(projection.project(used, x, 0.01));
  EXPECT_EQ(guard.allocations(), 0u);
}

}  // namespace
}  // namespace haptic::core
