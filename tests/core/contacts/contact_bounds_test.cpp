// Bounds of contacts, whatever is told: how far they lead the proxy, how much a tick
// costs, and that a probe at rest has a proxy at rest (core/METHOD.md#contacts).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "haptic/core/contacts/plane_projection.hpp"
#include "tests/support/solved_contacts.hpp"
#include "tests/support/vectors.hpp"

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
    for (double& entry : x.reshaped()) entry = size * normal();
    return x;
  }
  /// Unit normals around `x`, some nearly parallel or opposite; some of the contacts rigid.
  PlaneSet contacts(int n_x, int count, const VecX& x) {
    PlaneSet set;
    set.normals.resize(n_x, count);
    set.offsets.resize(count);
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

ConfigurationSpace reals(int n_x) {
  return ConfigurationSpace(std::vector<Coordinate>(static_cast<std::size_t>(n_x)));
}

VecX answer(PlaneProjection& projection, const VecX& probe) {
  VecX x;
  static_cast<void>(projection.project(probe, x));
  return x;
}

TEST(ContactBounds, NearlyOppositePlanesDoNotDrag) {
  const ConfigurationSpace space = reals(2);
  PlaneProjection projection(space);
  const VecX free = two(0, 0);
  for (double angle = 1e-9; angle < 0.2; angle *= 3.0) {
    for (const double gamma : {0.0, 1e-8, 1e-4, 1e-2}) {
      PlaneSet slot;
      slot.normals = (MatXQ(2, 2) << 1, -std::cos(angle), 0, std::sin(angle)).finished();
      slot.offsets = two(-5e-5, -5e-5);  // told to overlap; the client is free there
      slot.compliance = two(gamma, gamma);
      projection.set(slot, free, &free);
      EXPECT_EQ(answer(projection, free), free) << angle << ' ' << gamma;
      for (const double moved : {-1e-3, 1e-5, 1e-3}) {
        const VecX probe = two(moved, 0);
        EXPECT_LE((answer(projection, probe) - probe).norm(), std::abs(moved) * (1.0 + 1e-9));
      }
    }
  }
}

TEST(ContactBounds, FreeClientIsFreeWhereTold) {
  Told told(1);
  for (int n = 0; n < 3000; ++n) {
    const int n_x = 1 + told.below(5);
    const ConfigurationSpace space = reals(n_x);
    PlaneProjection projection(space);
    const VecX free = told.point(n_x, 1.0);
    const PlaneSet set = told.contacts(n_x, 1 + told.below(12), free);
    projection.set(set, free, &free);
    ASSERT_EQ(answer(projection, free), free) << n;
    for (int k = 0; k < 10; ++k) {
      const VecX probe = free + told.point(n_x, 0.1);
      if ((set.normals.transpose() * probe - set.offsets).maxCoeff() > 0.0) continue;
      ASSERT_EQ(answer(projection, probe), probe) << n;
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
    const ConfigurationSpace space = reals(n_x);
    PlaneProjection projection(space);
    const VecX x = told.point(n_x, 1.0);
    const double length = told.decades(-6.0, 0.0);
    const VecX used = x + told.point(n_x, length);
    projection.set(told.contacts(n_x, 1 + told.below(12), x), x, &used);
    const double own = (used - x).norm();
    ASSERT_LE(projection.unexplained(), own * (1.0 + 1e-9));
    for (int k = 0; k < 5; ++k) {
      const VecX probe = used + told.point(n_x, k * length);
      const double spring = (answer(projection, probe) - probe).norm();
      ASSERT_LE(spring, 2.01 * own + (probe - used).norm() + 1e-9) << n << ' ' << k;
      most = std::max(most, spring / (own + (probe - used).norm()));
    }
  }
  EXPECT_GT(most, 0.9) << "or it tests nothing";
}

/// Without an anchor: by the violations of the probe, and continuous where contacts begin to
/// contradict each other.
/// Nearly parallel contacts, a third of them rigid, whose client solved its own law: their anchor
/// asks for more work than a sample may cost.
TEST(ContactBounds, ManyHonestContactsAreFelt) {
  Told told(12);
  for (const int n_x : {2, 3}) {
    const ConfigurationSpace space = reals(n_x);
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
      EXPECT_LE((answer(projection, probe) - x_0).norm(), 0.01 * (probe - x_0).norm()) << k;
    }
  }
}

TEST(ContactBounds, ToldContactsLeadContinuously) {
  Told told(3);
  int infeasible = 0, changed = 0;
  for (int n = 0; n < 2000; ++n) {
    const int n_x = 1 + told.below(5), count = 1 + told.below(12);
    const ConfigurationSpace space = reals(n_x);
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
    const ConfigurationSpace space = reals(n_x);
    PlaneProjection projection(space);
    const VecX x = told.point(n_x, 1.0), probe = x + told.point(n_x, 0.03);
    projection.set(balls(told, n_x, 1 + told.below(4), x, -2.0, n % 2 == 1), x);
    for (int tick = 0; tick < 300; ++tick) static_cast<void>(answer(projection, probe));
    const VecX rest = answer(projection, probe);
    ASSERT_LE((answer(projection, probe) - rest).norm(), 1e-7) << n;
    curved += projection.active() != 0 ? 1 : 0;
  }
  EXPECT_GT(curved, 1000);
}

/// The review's sample: 32 contacts that curve in 4 of 24 coordinates, under a full metric.
TEST(ContactBounds, HostileSampleCostsBoundedWork) {
  Told told(5);
  const int n_x = 24;
  Eigen::MatrixXd B(n_x, n_x);
  for (double& entry : B.reshaped()) entry = told.normal();
  const TaskMetric metric = TaskMetric::from_matrix(
      Eigen::MatrixXd(B * B.transpose() + 0.05 * Eigen::MatrixXd::Identity(n_x, n_x)));
  const ConfigurationSpace space = reals(n_x);
  PlaneProjection projection(space, metric);
  int most = 0;
  for (int n = 0; n < 300; ++n) {
    const VecX x = told.point(n_x, 1.0), used = x + told.point(n_x, 0.3);
    PlaneSet set = told.contacts(n_x, kMaxPlanes, x);
    set.curvature.resize(kMaxPlanes * PlaneSet::triangle(4));
    for (double& entry : set.curvature.reshaped()) entry = told.decades(-1.0, 2.0) * told.normal();
    for (std::size_t i = 0; i < kMaxPlanes; ++i) {
      set.curved[i] = 4;
      set.first[i] = static_cast<std::uint8_t>(told.below(21));
    }
    projection.set(set, x, &used);
    const int taken = projection.multiplications();
    for (int tick = 0; tick < 5; ++tick) {
      static_cast<void>(answer(projection, x + told.point(n_x, 0.3)));
      const int sum = projection.multiplications() + (tick == 0 ? taken : 0);
      const int one_system = kMaxPlanes * kMaxPlanes * (2 + kMaxPlanes / 6);
      ASSERT_LE(sum, 2 * (PlaneProjection::kMostWork + one_system));
      ASSERT_LE(projection.linearisations(), 2);
      most = std::max(most, sum);
    }
  }
  EXPECT_GT(most, PlaneProjection::kMostWork / 2) << "or it is no hostile sample";
}

}  // namespace
}  // namespace haptic::core::contact_bounds_test
