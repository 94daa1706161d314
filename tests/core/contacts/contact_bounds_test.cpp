// Bounds of contacts, whatever is told: how far they lead the proxy, how much a tick
// costs, and that a probe at rest has a proxy at rest (core/METHOD.md#contacts).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/core/contacts/told_planes.hpp"
#include "tests/support/solved_contacts.hpp"

namespace haptic::core::contact_bounds_test {
namespace {

class Told {
 public:
  explicit Told(std::uint32_t seed) : random_(seed) {}
  double normal() { return std::normal_distribution<double>()(random_); }
  double decades(double from, double to) {
    return std::pow(10.0, std::uniform_real_distribution<double>(from, to)(random_));
  }
  int below(int n) { return static_cast<int>(random_() % static_cast<std::uint32_t>(n)); }
  VecX point(int n_x, double size) {
    VecX x(n_x);
    fill(x, [&] { return size * normal(); });
    return x;
  }
  /// Unit normals around `x`, some nearly parallel or opposite; some of the contacts rigid.
  PlaneSet contacts(int n_x, int count, const VecX& x) {
    PlaneSet set = planes_of(n_x, count);
    set.compliance.resize(count);
    for (int i = 0; i < count; ++i) {
      set.normals.col(i) = point(n_x, 1.0);
      if (i > 0 && below(2) == 0) {
        set.normals.col(i) = (below(2) == 0 ? 1.0 : -1.0) * set.normals.col(below(i)) +
                             point(n_x, decades(-12.0, -1.0));
      }
      set.normals.col(i).normalize();
      set.offsets[i] = set.normals.col(i).dot(x) + 0.1 * normal();
      set.compliance[i] = below(2) == 0 ? 0.0 : decades(-8.0, 2.0);
    }
    return set;
  }

 private:
  std::mt19937 random_;
};

TEST(ContactBounds, FreeClientIsFreeWhereTold) {
  Told told(1);
  for (int n = 0; n < 3000; ++n) {
    const int n_x = 1 + told.below(5);
    const ConfigurationSpace space = line_space(n_x);
    PlaneProjection projection(space);
    const VecX free = told.point(n_x, 1.0);
    const PlaneSet set = told.contacts(n_x, 1 + told.below(12), free);
    projection.set(set, free, &free);
    ASSERT_EQ(led_to(projection, free), free) << n;
    for (int k = 0; k < 10; ++k) {
      const VecX probe = free + told.point(n_x, 0.1);
      if ((set.normals.transpose() * probe - set.offsets).maxCoeff() > 0.0) continue;
      ASSERT_EQ(led_to(projection, probe), probe) << n;
    }
  }
}

/// The spring at the anchor is at most twice the client's own, and x moves no further than the
/// probe.
TEST(ContactBounds, AnchoredSpringIsBounded) {
  Told told(2);
  double most = 0.0;
  for (int n = 0; n < 5000; ++n) {
    const int n_x = 1 + told.below(5);
    const ConfigurationSpace space = line_space(n_x);
    PlaneProjection projection(space);
    const VecX x = told.point(n_x, 1.0);
    const double length = told.decades(-6.0, 0.0);
    const VecX used = x + told.point(n_x, length);
    projection.set(told.contacts(n_x, 1 + told.below(12), x), x, &used);
    const double own = (used - x).norm();
    ASSERT_LE(projection.unexplained(), own * (1.0 + 1e-9));
    for (int k = 0; k < 5; ++k) {
      const VecX probe = used + told.point(n_x, k * length);
      const double spring = (led_to(projection, probe) - probe).norm();
      ASSERT_LE(spring, 2.01 * own + (probe - used).norm() + 1e-9) << n << ' ' << k;
      most = std::max(most, spring / (own + (probe - used).norm()));
    }
  }
  EXPECT_GT(most, 0.9) << "or it tests nothing";
}

/// Nearly parallel contacts, a third of them rigid, whose client solved its own law: their anchor
/// asks for more work than a sample may cost.
TEST(ContactBounds, ManyHonestContactsAreFelt) {
  Told told(12);
  for (const int n_x : {2, 3}) {
    const ConfigurationSpace space = line_space(n_x);
    for (int k = 0; k < 50; ++k) {
      PlaneSet set = told.contacts(n_x, kMaxPlanes, VecX::Zero(n_x));
      const VecX along = told.point(n_x, 1.0);
      for (int i = 0; i < set.size(); ++i) {
        set.normals.col(i) = along + told.point(n_x, std::pow(10.0, -1 - k % 4));
        set.normals.col(i).normalize();
        set.offsets[i] = -0.003 + 0.002 * told.normal();
        set.compliance[i] = told.below(3) == 0 ? 0.0 : told.decades(-1.0, 1.0);
      }
      const VecX probe = VecX::Zero(n_x), x_0 = haptic::test::solved(set, probe);
      PlaneProjection projection(space);
      projection.set(set, x_0, &probe);
      EXPECT_LE((led_to(projection, probe) - x_0).norm(), 0.01 * (probe - x_0).norm()) << k;
    }
  }
}

/// Without an anchor: by the violations of the probe, and continuous if contacts begin to
/// contradict each other.
TEST(ContactBounds, ToldContactsLeadContinuously) {
  Told told(3);
  int infeasible = 0, changed = 0;
  for (int n = 0; n < 2000; ++n) {
    const int n_x = 1 + told.below(5), count = 1 + told.below(12);
    const ConfigurationSpace space = line_space(n_x);
    PlaneProjection projection(space);
    const VecX at = told.point(n_x, 1.0), way = told.point(n_x, 1.0).normalized();
    const PlaneSet set = told.contacts(n_x, count, at);
    projection.set(set, at);
    VecX probe = at + told.point(n_x, 0.3), before, x;
    PlaneStatus was = projection.project(probe, before);
    for (int k = 0; k < 60; ++k) {
      const VecX next = probe + 1e-3 * way;
      const PlaneStatus is = projection.project(next, x);
      ASSERT_LE((x - before).norm(), 1.1e-3) << n << ' ' << k;
      const VecX beyond = (set.normals.transpose() * next - set.offsets).cwiseMax(0.0);
      ASSERT_LE((x - next).norm(), 4900.0 * beyond.norm() * (1.0 + 1e-9)) << n;
      infeasible += is == PlaneStatus::kInfeasible ? 1 : 0;
      changed += is != was ? 1 : 0;
      was = is;
      probe = next;
      before = x;
    }
  }
  EXPECT_GT(infeasible, 1000);
  EXPECT_GT(changed, 5);
}

/// Balls of radius R (< 0: hollow) that the proxy touches near `x`.
PlaneSet balls(Told& told, int n_x, int count, const VecX& x, double least_decade, bool hollow) {
  PlaneSet set = told.contacts(n_x, count, x);
  std::vector<double> H;
  for (int i = 0; i < count; ++i) {
    set.offsets[i] = set.normals.col(i).dot(x) + 0.003 * told.normal();
    const double R = (hollow && told.below(2) == 0 ? -1.0 : 1.0) * told.decades(least_decade, 0.0);
    for (int a = 0; a < n_x; ++a) {
      for (int b = 0; b <= a; ++b) {
        H.push_back(((a == b ? 1.0 : 0.0) - set.normals(a, i) * set.normals(b, i)) / R);
      }
    }
    set.curved[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(n_x);
  }
  set.curvature = Eigen::Map<Eigen::VectorXd>(H.data(), static_cast<Eigen::Index>(H.size()));
  return set;
}

TEST(ContactBounds, ProxyRestsWhereTheProbeRests) {
  Told told(4);
  int curved = 0;
  for (int n = 0; n < 6000; ++n) {
    const int n_x = 2 + told.below(2);
    const ConfigurationSpace space = line_space(n_x);
    PlaneProjection projection(space);
    const VecX x = told.point(n_x, 1.0), probe = x + told.point(n_x, 0.03);
    projection.set(balls(told, n_x, 1 + told.below(4), x, -2.0, n % 2 == 1), x);
    for (int tick = 0; tick < 300; ++tick) static_cast<void>(led_to(projection, probe));
    const VecX rest = led_to(projection, probe);
    ASSERT_LE((led_to(projection, probe) - rest).norm(), 1e-7) << n;
    curved += projection.active() != 0 ? 1 : 0;
  }
  EXPECT_GT(curved, 1000);
}

/// 32 contacts that curve in 4 of 24 coordinates, under a full metric.
TEST(ContactBounds, HostileSampleCostsBoundedWork) {
  Told told(5);
  const int n_x = 24;
  Eigen::MatrixXd B(n_x, n_x);
  fill(B, [&] { return told.normal(); });
  const TaskMetric metric = TaskMetric::from_matrix(
      Eigen::MatrixXd(B * B.transpose() + 0.05 * Eigen::MatrixXd::Identity(n_x, n_x)));
  const ConfigurationSpace space = line_space(n_x);
  PlaneProjection projection(space, metric);
  int most = 0;
  for (int n = 0; n < 300; ++n) {
    const VecX x = told.point(n_x, 1.0), used = x + told.point(n_x, 0.3);
    PlaneSet set = told.contacts(n_x, kMaxPlanes, x);
    set.curvature.resize(kMaxPlanes * PlaneSet::triangle(4));
    fill(set.curvature, [&] { return told.decades(-1.0, 2.0) * told.normal(); });
    for (std::size_t i = 0; i < kMaxPlanes; ++i) {
      set.curved[i] = 4;
      set.first[i] = static_cast<std::uint8_t>(told.below(21));
    }
    projection.set(set, x, &used);
    const int taken = projection.multiplications();
    for (int tick = 0; tick < 5; ++tick) {
      static_cast<void>(led_to(projection, x + told.point(n_x, 0.3)));
      const int sum = projection.multiplications() + (tick == 0 ? taken : 0);
      const int one_system = kMaxPlanes * kMaxPlanes * (2 + kMaxPlanes / 6);
      ASSERT_LE(sum, 2 * (PlaneProjection::kMostWork + one_system));
      ASSERT_LE(projection.linearisations(), 2);
      most = std::max(most, sum);
    }
  }
  EXPECT_GT(most, PlaneProjection::kMostWork / 2) << "or it is no hostile sample";
}

constexpr int kMany = 40, kFirst = 17;  // three are named from there on

/// Two soft curved contacts on one object, in the three coordinates from `first` on of n_x.
PlaneSet few_of(int n_x, int first) {
  PlaneSet set = planes_of(n_x, 2);
  set.normals.col(0).segment<2>(first) << 1.0, 0.5;  // its curvature names another coordinate
  set.normals.col(1).segment<2>(first + 1) << 0.8, -1.0;
  set.offsets.setConstant(0.01);
  set.compliance.setConstant(2, 0.5);
  set.velocity.setZero(2);
  set.laws.resize(4, 2);
  set.laws.colwise() = Eigen::Vector4d(1e-3, 0.01, 0.5, -0.002);
  set.objects.setZero(Eigen::NoChange, 2);
  set.objects.row(0).setOnes();
  set.objects(1, 0) = set.objects(1, 1) = 1.0;
  set.curvature.resize(6);
  set.curvature << 4.0, 1.0, 3.0, 5.0, -1.0, 2.0;
  set.curved[0] = set.curved[1] = 2;
  set.first[0] = static_cast<std::uint8_t>(first + 1);
  set.first[1] = static_cast<std::uint8_t>(first);
  return set;
}

/// 30 ticks behind an anchored sample.
std::vector<VecX> run(int n_x, int first, const TaskMetric& metric) {
  const ConfigurationSpace space = line_space(n_x);
  PlaneProjection projection(space, metric);
  VecX at = VecX::Zero(n_x), used = VecX::Zero(n_x);
  used.segment<3>(first) << 0.02, 0.01, -0.01;
  at.segment<3>(first) << 0.015, 0.008, -0.005;
  projection.set(few_of(n_x, first), at, &used);
  std::vector<VecX> way;
  for (int k = 0; k < 30; ++k) {
    VecX probe = used;
    probe[first] += 1e-3 * k;
    way.push_back(led_to(projection, probe, 0.0, 1e-3));
  }
  return way;
}

/// W on the three coordinates, and 1 on the others.
TaskMetric metric_of(int n_x, int first, double mixed) {
  Eigen::MatrixXd W = Eigen::MatrixXd::Identity(n_x, n_x);
  W.block<3, 3>(first, first) << 2.0, mixed, 0.0, mixed, 3.0, mixed, 0.0, mixed, 1.5;
  return TaskMetric::from_matrix(W);
}

TEST(ContactBounds, FewOfManyCoordinatesAreAlike) {
  for (const double mixed : {-1.0, 0.0, 0.4}) {
    SCOPED_TRACE(mixed);
    const TaskMetric few = mixed < 0.0 ? TaskMetric() : metric_of(3, 0, mixed);
    const TaskMetric many = mixed < 0.0 ? TaskMetric() : metric_of(kMany, kFirst, mixed);
    const std::vector<VecX> alone = run(3, 0, few), among = run(kMany, kFirst, many);
    double moved = 0.0;
    for (std::size_t k = 0; k < alone.size(); ++k) {
      EXPECT_NEAR((among[k].segment<3>(kFirst) - alone[k]).norm(), 0.0, 1e-12) << k;
      EXPECT_NEAR(among[k].norm(), alone[k].norm(), 1e-12) << "the others stay";
      moved = std::max(moved, (alone[k] - alone[0]).norm());
    }
    EXPECT_GT(moved, 1e-3);
  }
}

}  // namespace
}  // namespace haptic::core::contact_bounds_test
