#include "haptic/core/rendering/block_renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "tests/core/linear/random_matrix.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;

const Kinematics& three_fingered() {
  static const auto map =
      make_hand_exoskeleton({five_fingers()[0], five_fingers()[1], five_fingers()[2]});
  return *map;
}

const VecA kStiffness = (VecA(3) << 900, 1500, 2000).finished();

VecX random_joints(std::mt19937_64& random) {
  std::uniform_real_distribution<double> angle(15 * kDegree, 45 * kDegree);
  VecX x(6);
  for (double& joint : x) joint = angle(random);
  return x;
}

/// The hand in one pose, its proxy in another.
Instant instant(const VecX& pose, const VecX& proxy) {
  VecQ q;
  EXPECT_EQ(three_fingered().inverse(pose, q), InverseStatus::kExact);
  return {three_fingered(), q, proxy};
}

/// Finger i of it alone.
Instant finger_of(const Instant& all, int i) {
  const MapBlock& block = three_fingered().blocks()[static_cast<std::size_t>(i)];
  return {*block.kinematics, all.q.segment(block.first_q, 2), all.x.segment(block.first_x, 2)};
}

TEST(BlockRenderer, RendersEachFingerAsIfAlone) {
  std::mt19937_64 random(1);
  for (const RendererKind kind : kEveryRenderer) {
    SCOPED_TRACE(std::string(name(kind)));
    BlockRenderer renderer(kind, three_fingered());
    EXPECT_EQ(renderer.kind(), kind);
    std::vector<Renderer> alone;
    for (const MapBlock& block : three_fingered().blocks())
      alone.emplace_back(kind, *block.kinematics);
    for (int trial = 0; trial < 100; ++trial) {
      const VecX pose = random_joints(random);
      const Instant all = instant(pose, random_joints(random));
      const Projection out = projected(renderer, all, kStiffness);
      double squares = 0.0;
      for (int i = 0; i < 3; ++i) {
        const Projection one = projected(alone[static_cast<std::size_t>(i)], finger_of(all, i),
                                         kStiffness.segment<1>(i));
        EXPECT_EQ(VecQ(out.q_star.segment<2>(2 * i)), one.q_star);
        EXPECT_GE(out.status, one.status);
        EXPECT_GE(out.condition, one.condition);
        squares += one.residual * one.residual;
      }
      EXPECT_DOUBLE_EQ(out.residual, std::sqrt(squares));
    }
  }
}

/// Eq. (6) and (8) do not care whether J is block diagonal; the dense solve is the independent
/// word.
TEST(BlockRenderer, AgreesWithTheDenseSolve) {
  std::mt19937_64 random(2);
  for (const RendererKind kind : {RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
    BlockRenderer blocks(kind, three_fingered());
    Renderer dense(kind, three_fingered());
    for (int trial = 0; trial < 200; ++trial) {
      const VecX pose = random_joints(random);
      const Instant all = instant(pose, random_joints(random));
      const Projection one = projected(blocks, all, kStiffness);
      const Projection other = projected(dense, all, kStiffness);
      EXPECT_LT((one.q_star - other.q_star).norm(), 1e-11 * other.q_star.norm());
      EXPECT_EQ(one.status, other.status);
    }
  }
}

/// A finger that counts how often Eq. (6) is solved on it.
class SolvedFinger final : public samples::Wrapped {
 public:
  SolvedFinger() : Wrapped(*three_fingered().blocks()[1].kinematics) {}
  mutable int solved{0};
  InverseStatus inverse(const VecX& x, VecQ& q) const noexcept override {
    ++solved;
    return map().inverse(x, q);
  }
};

/// Three of them side by side.
class SolvedHand final : public samples::Wrapped {
 public:
  SolvedHand() : Wrapped(three_fingered()) {}
  SolvedFinger fingers[3];
  std::span<const MapBlock> blocks() const noexcept override { return blocks_; }

 private:
  std::vector<MapBlock> blocks_{
      {&fingers[0], 0, 0, 0}, {&fingers[1], 2, 1, 2}, {&fingers[2], 4, 2, 4}};
};

TEST(BlockRenderer, SolvesOnlyBlocksWithChangedProxy) {
  std::mt19937_64 random(3);
  SolvedHand hand;
  BlockRenderer renderer(RendererKind::kSubspaceExact, hand);
  const VecX pose = random_joints(random);
  Instant all = instant(pose, random_joints(random));
  const Projection first = projected(renderer, all, kStiffness);
  all.x[3] += 0.01;  // the second finger's PIP
  const Projection out = projected(renderer, all, kStiffness);
  EXPECT_EQ(hand.fingers[0].solved, 1);
  EXPECT_EQ(hand.fingers[1].solved, 2);
  EXPECT_EQ(hand.fingers[2].solved, 1);
  EXPECT_EQ(VecQ(out.q_star.segment<2>(0)), VecQ(first.q_star.segment<2>(0)));
  EXPECT_NE(VecQ(out.q_star.segment<2>(2)), VecQ(first.q_star.segment<2>(2)));
  projected(renderer, all, kStiffness);  // a frame that says the same
  projected(renderer, all, kStiffness, false);
  EXPECT_EQ(hand.fingers[1].solved, 2);
  renderer.reset();
  projected(renderer, all, kStiffness);
  for (const SolvedFinger& finger : hand.fingers) EXPECT_GE(finger.solved, 2);
}

/// -d tau_a/dq_a with the proxy held is found by moving each actuator by itself: on a linear map
/// any step is exact.
TEST(BlockRenderer, BoundsABaselinesDisplayedStiffness) {
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 300; ++trial) {
    const int n_x = 4, n_q = 3, n_a = 1 + trial % 3;
    const auto map =
        samples::linear_map((trial % 2 == 0 ? 3.0 : 0.3) * gaussian(random, n_x, n_q), n_a);
    const VecX x = gaussian(random, n_x, 1);
    const VecA Z_q = VecA(gaussian(random, n_a, 1)).cwiseAbs() + VecA::Constant(n_a, 0.1);
    for (const RendererKind kind : kEveryRenderer) {
      BlockRenderer renderer(kind, *map);
      VecA ratio;
      const auto force = [&](const VecQ& q) {
        const Instant at(*map, q, x);
        const Projection out = projected(renderer, at, Z_q);
        renderer.displayed_bound(at.probe(), at.dx, Z_q, ratio);
        return spring_force(map->layout(), out, q, Z_q);
      };
      const VecA at_rest = force(VecQ::Zero(n_q));
      Eigen::MatrixXd K(n_a, n_a);
      for (int i = 0; i < n_a; ++i) K.col(i) = at_rest - force(VecQ::Unit(n_q, i));
      ASSERT_GE(ratio.minCoeff(), 1.0);
      const Eigen::MatrixXd room = Eigen::MatrixXd(ratio.cwiseProduct(Z_q).asDiagonal()) - K;
      ASSERT_GE(oracle::smallest_eigenvalue(room), -1e-9 * Z_q.maxCoeff()) << name(kind);
      if (n_a == 1 && kind == RendererKind::kStandard) {  // then it is no bound but the stiffness
        ASSERT_NEAR(ratio[0], std::max(1.0, K(0, 0) / Z_q[0]), 1e-11 * ratio[0]);
      }
    }
  }
}

TEST(BlockRenderer, BoundsActiveFingersSeparately) {
  std::mt19937_64 random(8);
  const VecX pose = random_joints(random);
  VecX proxy = pose;
  proxy.segment<2>(2) = random_joints(random).segment<2>(2);
  const Instant all = instant(pose, proxy), index = finger_of(all, 1);
  BlockRenderer renderer(RendererKind::kStandard, three_fingered());
  BlockRenderer alone(RendererKind::kStandard, *three_fingered().blocks()[1].kinematics);
  VecX dx = all.dx;
  for (const int idle : {0, 1, 4, 5}) dx[idle] = 0.0;  // the pose's own rounding
  VecA ratio, one;
  renderer.displayed_bound(all.probe(), dx, kStiffness, ratio);
  alone.displayed_bound(index.probe(), index.dx, kStiffness.segment<1>(1), one);
  EXPECT_EQ(ratio, (VecA(3) << 1.0, one[0], 1.0).finished());
}

}  // namespace
}  // namespace haptic::core
