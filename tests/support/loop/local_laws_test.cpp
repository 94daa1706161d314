#include "tests/support/loop/local_laws.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::test {
namespace {

using core::VecQ;
using core::VecX;

constexpr double kNone = std::numeric_limits<double>::infinity();

Frame frame(double seen, const VecX& x_probe, const VecX& x) {
  Frame f;
  f.seen_s = seen;
  f.x_probe = x_probe;
  f.x = x;
  return f;
}

TEST(LocalLaw, AHeldDeviationMovesWithTheProbe) {
  const Frame sample = frame(0.0, two(0.5, 0.2), two(0.3, 0.2));
  const VecX now = two(0.6, 0.1);
  const VecX x = held_deviation()({sample, sample, 0.01, now, now});
  EXPECT_NEAR((x - now - two(-0.2, 0.0)).norm(), 0.0, 1e-15);
}

TEST(LocalLaw, ExtrapolationGoesOnForOnePeriodAtMost) {
  const Frame first = frame(1.00, two(0, 0), two(0.10, 0.20));
  const Frame second = frame(1.02, two(0, 0), two(0.14, 0.18));
  const VecX now = two(0, 0);
  const auto at = [&](double since) { return extrapolated()({second, first, since, now, now}); };
  EXPECT_EQ(at(0.0), second.x);
  EXPECT_NEAR((at(0.01) - two(0.16, 0.17)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((at(0.02) - two(0.18, 0.16)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((at(0.10) - at(0.02)).norm(), 0.0, 1e-14);
  EXPECT_EQ(extrapolated()({first, first, 0.1, now, now}), first.x) << "one sample has no rate";
}

/// The form that core/METHOD.md#local-models rejects, for the finger, of the deviation in q_a.
struct Finger {
  std::shared_ptr<const core::Kinematics> map = core::make_finger_exoskeleton({});
  VecX stop = two(0.3, kNone);
  double weight = 30.0;

  [[nodiscard]] VecQ q_of(const VecX& x) const {
    VecQ q = VecQ::Zero(2);
    EXPECT_EQ(map->inverse(x, q), core::InverseStatus::kExact);
    return q;
  }
  [[nodiscard]] VecX proxy(const VecQ& reference, double l) const {
    Frame sample;
    sample.q = reference;
    VecQ q = reference;
    q[0] = l;
    VecX x = VecX::Zero(2);
    core::MatXQ J = core::MatXQ::Zero(2, 2);
    EXPECT_EQ(map->evaluate(q, x, J), core::MapStatus::kOk);
    return q_metric({map, stop, weight})({sample, sample, 0.0, q, x});
  }
};

TEST(QMetric, IsTheNearestAllowedPoseInItsMetric) {
  for (const VecX& stop : {two(0.3, kNone), two(kNone, 0.4), two(0.3, 0.4)}) {
    Finger finger;
    finger.stop = stop;
    const VecQ aim = finger.q_of(two(0.6, 0.7));
    const auto distance = [&](const VecX& x) {
      VecQ q = aim;
      if (finger.map->inverse(x, q) != core::InverseStatus::kExact) return kNone;
      const double l = q[0] - aim[0], angle = 0.02 * (q[1] - aim[1]);
      return l * l + finger.weight * angle * angle;
    };
    const VecX x = finger.proxy(aim, aim[0]);
    EXPECT_LE(x[0], stop[0] + 1e-12);
    EXPECT_LE(x[1], stop[1] + 1e-12);
    double least = kNone;
    for (double mcp = 0.0; mcp <= std::min(stop[0], 1.2); mcp += 0.01) {
      for (double pip = 0.0; pip <= std::min(stop[1], 1.6); pip += 0.01) {
        least = std::min(least, distance(two(mcp, pip)));
      }
    }
    EXPECT_LE(distance(x), least * (1.0 + 1e-9));
  }
}

TEST(QMetric, LeavesAnAllowedPoseAlone) {
  Finger finger;
  const VecQ q = finger.q_of(two(0.25, 0.7));
  EXPECT_NEAR((finger.proxy(q, q[0]) - two(0.25, 0.7)).norm(), 0.0, 1e-12);
}

TEST(QMetric, ItsStiffnessLiesBetweenZeroAndZq) {
  const Finger finger;
  const VecQ reference = finger.q_of(two(0.5, 0.6));
  const auto deviation = [&](double l) { return finger.q_of(finger.proxy(reference, l))[0] - l; };
  constexpr double kStep = 1e-5;
  for (double l = reference[0] - 0.004; l < reference[0] + 0.004; l += 2e-4) {
    const double slope = (deviation(l + kStep) - deviation(l - kStep)) / (2.0 * kStep);
    EXPECT_LE(slope, 1e-6) << l;
    EXPECT_GE(slope, -1.0 - 1e-6) << l;
  }
}

TEST(EnergyBook, CountsTheHeldForceExactlyAndItsLargestSum) {
  EnergyBook book(2.0);
  book.add(3.0, 0.010, 0.1);   // 30 mJ given, 2 mJ to the damping
  book.add(-4.0, 0.020, 0.1);  // 80 mJ taken
  EXPECT_NEAR(book.given(), -0.050, 1e-15);
  EXPECT_NEAR(book.net(), 0.030 - 0.002 - 0.080 - 0.008, 1e-15);
  EXPECT_NEAR(book.most_net(), 0.028, 1e-15);
  book.begin_cycle();
  book.add(1.0, 0.001, 0.1);
  EXPECT_NEAR(book.given(), 0.001, 1e-15);
  EXPECT_NEAR(book.most_net(), 0.028, 1e-15);
}

}  // namespace
}  // namespace haptic::test
