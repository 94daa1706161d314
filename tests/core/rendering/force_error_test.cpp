// Error of the proxy at the actuators, by each renderer (core/METHOD.md#error-bound).
#include "haptic/core/rendering/force_error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/rendering/block_renderer.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core::force_error_test {
namespace {

const Kinematics& two_fingered() {
  static const auto map = make_hand_exoskeleton(
      {{"index", finger_sign_change()}, {"middle", scaled(finger_sign_change(), 1.1)}});
  return *map;
}

class ForceErrorTest : public testing::Test {
 protected:
  double uniform(double lowest, double highest) {
    return std::uniform_real_distribution<double>(lowest, highest)(random_);
  }
  VecX joints(double spread) {
    VecX x(4);
    for (int i = 0; i < 4; ++i) x[i] = (30.0 + uniform(-spread, spread)) * kDegree;
    return x;
  }
  VecA force(RendererKind kind, const VecQ& q, const VecX& x) {
    VecX x_probe, dx;
    MatXQ J;
    EXPECT_EQ(two_fingered().evaluate(q, x_probe, J), MapStatus::kOk);
    two_fingered().space().difference(x, x_probe, dx);
    Projection out;
    BlockRenderer(kind, two_fingered()).project({q, x_probe, J}, x, dx, stiffness_, true, out);
    q_star_ = out.q_star;
    const DofLayout& layout = two_fingered().layout();
    return stiffness_.cwiseProduct(layout.select(out.q_star) - layout.select(q));
  }

  std::mt19937_64 random_{4};
  const VecA stiffness_ = (VecA(2) << 900, 1500).finished();
  VecQ q_star_{};
};

TEST_F(ForceErrorTest, BoundsEveryRenderer) {
  const ProjectionModel model(two_fingered());
  ForceError force_error(model);
  for (const RendererKind kind : kEveryRenderer) {
    SCOPED_TRACE(std::string(name(kind)));
    double nearest = 0.0;
    for (int trial = 0; trial < 300; ++trial) {
      VecQ q;
      ASSERT_EQ(two_fingered().inverse(joints(15.0), q), InverseStatus::kExact);
      VecX x_probe;
      ASSERT_EQ(two_fingered().position(q, x_probe), MapStatus::kOk);
      VecX x = x_probe;
      for (int i = 0; i < 2; ++i) x[i] += uniform(-3.0, 3.0) * kDegree;  // index alone
      Contacts contacts;
      contacts.into = MatXQ::Zero(4, 1);
      contacts.into.col(0).head(2) =
          Eigen::Vector2d(uniform(-1.0, 1.0), uniform(-1.0, 1.0)).normalized();
      contacts.depth = VecX::Ones(1);
      ProxyError error;
      error.known = true;
      error.of = VecX::Constant(1, 1e-4);
      error.along = trial % 2 == 0 ? 0 : -1;
      const VecA here = force(kind, q, x);
      VecA bound;
      const VecQ& at = kind == RendererKind::kSubspaceExact ? q_star_ : q;
      const VecQ q_at = at;
      const test::AllocationGuard guard;
      ASSERT_TRUE(force_error.at({kind, q_at, stiffness_, {}, {}}, contacts, error, bound));
      EXPECT_EQ(guard.allocations(), 0u);
      EXPECT_EQ(bound[1], 0.0) << "nothing touches the middle finger";
      for (int way = 0; way < 8; ++way) {
        VecX off = VecX::Zero(4);
        if (error.along == 0) {
          off = uniform(-1.0, 1.0) * error.of[0] * contacts.into.col(0);
        } else {
          const double angle = way * M_PI / 4.0;
          off.head(2) = error.of[0] * Eigen::Vector2d(std::cos(angle), std::sin(angle));
        }
        const VecA there = force(kind, q, x + off);
        const double moved = std::abs(there[0] - here[0]);
        ASSERT_LE(moved, 1.02 * bound[0]);
        if (bound[0] > 0.0) nearest = std::max(nearest, moved / bound[0]);
      }
    }
    EXPECT_GT(nearest, 0.8) << "or the bound is vacuous";
  }
}

}  // namespace
}  // namespace haptic::core::force_error_test
