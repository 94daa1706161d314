#include "haptic/core/rendering/block_renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "haptic/core/model/hand_exoskeleton.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/core/rendering/function_map.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;

const Kinematics& five_fingered() {
  static const auto map = make_hand_exoskeleton({{"thumb", scaled(finger_sign_change(), 0.8)},
                                                 {"index", finger_sign_change()},
                                                 {"middle", scaled(finger_sign_change(), 1.1)}});
  return *map;
}

VecX random_joints(std::mt19937_64& random) {
  std::uniform_real_distribution<double> angle(15 * kDegree, 45 * kDegree);
  VecX x(6);
  for (int i = 0; i < 6; ++i) x[i] = angle(random);
  return x;
}

/// One instant of a hand: pose, proxy, difference.
struct Instant {
  VecQ q{};
  VecX x_probe{}, x{}, dx{};
  MatXQ J{};
  VecA stiffness = (VecA(3) << 900, 1500, 2000).finished();

  Instant(const Kinematics& map, const VecX& pose, const VecX& proxy) : x(proxy) {
    EXPECT_EQ(map.inverse(pose, q), InverseStatus::kExact);
    EXPECT_EQ(map.evaluate(q, x_probe, J), MapStatus::kOk);
    map.space().difference(x, x_probe, dx);
  }
  [[nodiscard]] Probe probe() const { return {q, x_probe, J}; }
};

TEST(BlockRenderer, RendersEachFingerAsIfAlone) {
  std::mt19937_64 random(1);
  for (const RendererKind kind : kEveryRenderer) {
    SCOPED_TRACE(std::string(name(kind)));
    BlockRenderer renderer(kind, five_fingered());
    EXPECT_EQ(renderer.kind(), kind);
    std::vector<Renderer> alone;
    for (const MapBlock& block : five_fingered().blocks())
      alone.emplace_back(kind, *block.kinematics);
    for (int trial = 0; trial < 100; ++trial) {
      const Instant all(five_fingered(), random_joints(random), random_joints(random));
      Projection out;
      renderer.project(all.probe(), all.x, all.dx, all.stiffness, true, out);
      double squares = 0.0;
      for (int i = 0; i < 3; ++i) {
        const auto finger = static_cast<std::size_t>(i);
        const VecQ q = all.q.segment<2>(2 * i);
        const VecX x_probe = all.x_probe.segment<2>(2 * i), x = all.x.segment<2>(2 * i);
        const VecX dx = all.dx.segment<2>(2 * i);
        const MatXQ J = all.J.block<2, 2>(2 * i, 2 * i);
        Projection one;
        alone[finger].project(Probe{q, x_probe, J}, x, dx, all.stiffness.segment<1>(i), true, one);
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
    BlockRenderer blocks(kind, five_fingered());
    Renderer dense(kind, five_fingered());
    for (int trial = 0; trial < 200; ++trial) {
      const Instant all(five_fingered(), random_joints(random), random_joints(random));
      Projection one, other;
      blocks.project(all.probe(), all.x, all.dx, all.stiffness, true, one);
      dense.project(all.probe(), all.x, all.dx, all.stiffness, true, other);
      EXPECT_LT((one.q_star - other.q_star).norm(), 1e-11 * other.q_star.norm());
      EXPECT_EQ(one.status, other.status);
    }
  }
}

/// A finger that counts how often Eq. (6) is solved on it.
class SolvedFinger final : public Kinematics {
 public:
  SolvedFinger() : Kinematics(finger().dofs(), finger().space()) {}
  mutable int solved{0};
  MapStatus evaluate(const VecQ& q, VecX& x, MatXQ& J) const noexcept override {
    return finger().evaluate(q, x, J);
  }
  MapStatus second_order(const VecQ& q, int k, MatXQ& J_k) const noexcept override {
    return finger().second_order(q, k, J_k);
  }
  InverseStatus inverse(const VecX& x, VecQ& q) const noexcept override {
    ++solved;
    return finger().inverse(x, q);
  }

 private:
  static const Kinematics& finger() { return *five_fingered().blocks()[1].kinematics; }
};

/// Three of them side by side.
class SolvedHand final : public Kinematics {
 public:
  SolvedHand() : Kinematics(five_fingered().dofs(), five_fingered().space()) {}
  SolvedFinger fingers[3];
  std::span<const MapBlock> blocks() const noexcept override { return blocks_; }
  MapStatus evaluate(const VecQ& q, VecX& x, MatXQ& J) const noexcept override {
    return five_fingered().evaluate(q, x, J);
  }
  MapStatus second_order(const VecQ& q, int k, MatXQ& J_k) const noexcept override {
    return five_fingered().second_order(q, k, J_k);
  }

 private:
  std::vector<MapBlock> blocks_{
      {&fingers[0], 0, 0, 0}, {&fingers[1], 2, 1, 2}, {&fingers[2], 4, 2, 4}};
};

TEST(BlockRenderer, SolvesOnlyBlocksWithChangedProxy) {
  std::mt19937_64 random(3);
  SolvedHand solved_hand;
  BlockRenderer renderer(RendererKind::kSubspaceExact, solved_hand);
  Instant all(five_fingered(), random_joints(random), random_joints(random));
  Projection first, out;
  const auto solve = [&](bool changed) {
    renderer.project(all.probe(), all.x, all.dx, all.stiffness, changed, out);
  };
  solve(true);
  first = out;
  all.x[3] += 0.01;  // the second finger's PIP
  solve(true);
  EXPECT_EQ(solved_hand.fingers[0].solved, 1);
  EXPECT_EQ(solved_hand.fingers[1].solved, 2);
  EXPECT_EQ(solved_hand.fingers[2].solved, 1);
  EXPECT_EQ(VecQ(out.q_star.segment<2>(0)), VecQ(first.q_star.segment<2>(0)));
  EXPECT_NE(VecQ(out.q_star.segment<2>(2)), VecQ(first.q_star.segment<2>(2)));
  solve(true);  // a frame that says the same
  solve(false);
  EXPECT_EQ(solved_hand.fingers[1].solved, 2);
  renderer.reset();
  solve(true);
  for (const SolvedFinger& finger : solved_hand.fingers) EXPECT_GE(finger.solved, 2);
}

TEST(BlockRenderer, NeverAllocates) {
  std::mt19937_64 random(4);
  const Instant all(five_fingered(), random_joints(random), random_joints(random));
  for (const RendererKind kind : kEveryRenderer) {
    BlockRenderer renderer(kind, five_fingered());
    Projection out;
    const test::AllocationGuard guard;
    renderer.project(all.probe(), all.x, all.dx, all.stiffness, true, out);
    renderer.reset();
    renderer.project(all.probe(), all.x, all.dx, all.stiffness, false, out);
    EXPECT_EQ(guard.allocations(), 0u);
  }
}

/// -d tau_a/dq_a with the proxy held is found by moving each actuator by itself: on a linear map
/// any step is exact.
TEST(BlockRenderer, BoundsABaselinesDisplayedStiffness) {
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 300; ++trial) {
    const int n_x = 4, n_q = 3, n_a = 1 + trial % 3;
    const MatXQ A = (trial % 2 == 0 ? 3.0 : 0.3) * gaussian(random, n_x, n_q);
    const samples::FunctionMap map(
        samples::dofs(n_q, n_a, 1e6), samples::coordinates(n_x),
        [A](const VecQ& q) { return VecX(A * q); }, [A](const VecQ&) { return A; });
    const VecX x = gaussian(random, n_x, 1);
    const VecA Z_q = VecA(gaussian(random, n_a, 1)).cwiseAbs() + VecA::Constant(n_a, 0.1);
    for (const RendererKind kind : kEveryRenderer) {
      BlockRenderer renderer(kind, map);
      VecA ratio, at_rest;
      const auto force = [&](const VecQ& q) {
        const VecX x_probe = A * q, dx = x - x_probe;
        Projection out;
        renderer.project({q, x_probe, A}, x, dx, Z_q, true, out);
        renderer.displayed_bound({q, x_probe, A}, dx, Z_q, ratio);
        return VecA(Z_q.cwiseProduct(map.layout().select(out.q_star - q)));
      };
      at_rest = force(VecQ::Zero(n_q));
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
  const Instant all(five_fingered(), pose, proxy);
  BlockRenderer renderer(RendererKind::kStandard, five_fingered());
  BlockRenderer alone(RendererKind::kStandard, *five_fingered().blocks()[1].kinematics);
  VecX dx = all.dx;
  for (const int idle : {0, 1, 4, 5}) dx[idle] = 0.0;  // the pose's own rounding
  VecA ratio, one;
  const VecQ q = all.q.segment<2>(2);
  const VecX x_probe = all.x_probe.segment<2>(2), d = dx.segment<2>(2);
  const MatXQ J = all.J.block<2, 2>(2, 2);
  const VecA Z_q = all.stiffness.segment<1>(1);
  const test::AllocationGuard allocations;
  renderer.displayed_bound(all.probe(), dx, all.stiffness, ratio);
  alone.displayed_bound({q, x_probe, J}, d, Z_q, one);
  EXPECT_EQ(allocations.allocations(), 0u);
  EXPECT_EQ(ratio[0], 1.0);
  EXPECT_EQ(ratio[1], one[0]);
  EXPECT_EQ(ratio[2], 1.0);
}

}  // namespace
}  // namespace haptic::core
