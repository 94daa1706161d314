#include "haptic/core/rendering/block_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <limits>
#include <random>

#include "haptic/core/model/stylus.hpp"
#include "haptic/core/passivity/direction_guard.hpp"
#include "haptic/core/rendering/block_renderer.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr BlockSet set_of(std::initializer_list<int> blocks) {
  BlockSet set = 0;
  for (const int block : blocks) set |= BlockSet{1} << block;
  return set;
}

/// A finger that counts what it is asked for.
class Counting final : public Kinematics {
 public:
  explicit Counting(const Kinematics& finger)
      : Kinematics(finger.dofs(), finger.space()), finger_(&finger) {}
  mutable int positions{0}, evaluations{0};
  MapStatus evaluate(const VecQ& q, VecX& x, MatXQ& J) const noexcept override {
    ++evaluations;
    return finger_->evaluate(q, x, J);
  }
  MapStatus position(const VecQ& q, VecX& x) const noexcept override {
    ++positions;
    return finger_->position(q, x);
  }
  MapStatus second_order(const VecQ& q, int k, MatXQ& J_k) const noexcept override {
    return finger_->second_order(q, k, J_k);
  }

 private:
  const Kinematics* finger_;
};

/// The five-fingered hand, each finger counting.
class CountingHand final : public Kinematics {
 public:
  explicit CountingHand(std::unique_ptr<Kinematics> hand = make_hand_exoskeleton(five_fingers()))
      : Kinematics(hand->dofs(), hand->space()), hand_(std::move(hand)) {
    for (const MapBlock& block : hand_->blocks()) fingers.emplace_back(*block.kinematics);
    for (std::size_t i = 0; i < fingers.size(); ++i) {
      blocks_.push_back(hand_->blocks()[i]);
      blocks_.back().kinematics = &fingers[i];
    }
  }
  std::deque<Counting> fingers{};
  [[nodiscard]] const Kinematics& whole() const { return *hand_; }
  std::span<const MapBlock> blocks() const noexcept override { return blocks_; }
  MapStatus evaluate(const VecQ& q, VecX& x, MatXQ& J) const noexcept override {
    return hand_->evaluate(q, x, J);
  }
  MapStatus second_order(const VecQ& q, int k, MatXQ& J_k) const noexcept override {
    return hand_->second_order(q, k, J_k);
  }

 private:
  std::unique_ptr<Kinematics> hand_;
  std::vector<MapBlock> blocks_{};
};

class BlockMapTest : public ::testing::Test {
 protected:
  VecQ random_pose() {
    std::uniform_real_distribution<double> angle(15 * kDegree, 45 * kDegree);
    VecX x(10);
    for (int i = 0; i < 10; ++i) x[i] = angle(random_);
    VecQ q;
    EXPECT_EQ(hand.whole().inverse(x, q), InverseStatus::kExact);
    return q;
  }
  void expect_as_the_whole(const BlockMap& map, const VecQ& q) const {
    VecX x;
    MatXQ J;
    ASSERT_EQ(hand.evaluate(q, x, J), MapStatus::kOk);
    EXPECT_EQ(map.x_probe(), x);
    EXPECT_EQ(map.J(), J);
  }
  std::mt19937_64 random_{7};
  CountingHand hand;
};

TEST_F(BlockMapTest, EqualsWholeMapToTheBit) {
  BlockMap map(hand);
  for (int trial = 0; trial < 50; ++trial) {
    const VecQ q = random_pose();
    ASSERT_EQ(map.move_to(q), 0u);
    map.differentiate(map.all());
    expect_as_the_whole(map, q);
  }
  const auto finger = make_finger_exoskeleton(finger_sign_change());  // a map without blocks
  BlockMap single(*finger);
  const VecQ q = random_pose().segment<2>(2);
  ASSERT_EQ(single.move_to(q), 0u);
  single.differentiate(single.all());
  VecX x;
  MatXQ J;
  ASSERT_EQ(finger->evaluate(q, x, J), MapStatus::kOk);
  EXPECT_EQ(single.x_probe(), x);
  EXPECT_EQ(single.J(), J);
}

TEST_F(BlockMapTest, EvaluatesOnlyWhatIsNeeded) {
  BlockMap map(hand);
  VecQ q = random_pose();
  constexpr BlockSet kIndex = 1u << 1;
  ASSERT_EQ(map.move_to(q), 0u);
  map.differentiate(kIndex);
  for (Counting& finger : hand.fingers) finger.positions = finger.evaluations = 0;
  for (int tick = 0; tick < 10; ++tick) {
    q[2] += 1e-4;  // the index moves and presses,
    q[4] += 1e-4;  // the middle moves freely,
    ASSERT_EQ(map.move_to(q), 0u);
    map.differentiate(kIndex);
    VecX x;
    MatXQ J;
    ASSERT_EQ(hand.evaluate(q, x, J), MapStatus::kOk);
    EXPECT_EQ(map.x_probe(), x);
    EXPECT_EQ((map.J().block<2, 2>(2, 2)), (J.block<2, 2>(2, 2)));
  }
  EXPECT_EQ(hand.fingers[1].evaluations, 10);
  EXPECT_EQ(hand.fingers[1].positions, 0);
  EXPECT_EQ(hand.fingers[2].evaluations, 0);
  EXPECT_EQ(hand.fingers[2].positions, 10);
  for (const std::size_t rests : {0u, 3u, 4u}) {
    EXPECT_EQ(hand.fingers[rests].evaluations + hand.fingers[rests].positions, 0);
  }
  map.differentiate(map.all());  // and a finger that comes to need it gets it in the same tick
  expect_as_the_whole(map, q);
}

TEST_F(BlockMapTest, FailedFingerKeepsLastOthersMove) {
  BlockMap map(hand);
  const VecQ good = random_pose();
  ASSERT_EQ(map.move_to(good), 0u);
  map.differentiate(map.all());
  const VecX before = map.x_probe();
  VecQ bad = random_pose();
  bad[2] = 0.02;
  bad[3] = -101 * kDegree;  // core/METHOD.md#map-without-a-value
  ASSERT_EQ(map.move_to(bad), set_of({1}));
  EXPECT_EQ(VecX(map.x_probe().segment(2, 2)), VecX(before.segment(2, 2)));
  VecQ others = bad;
  others.segment<2>(2) = good.segment<2>(2);
  VecX x;
  MatXQ J;
  ASSERT_EQ(hand.evaluate(others, x, J), MapStatus::kOk);
  EXPECT_EQ(map.x_probe(), x);
  EXPECT_EQ(map.move_to(bad), set_of({1})) << "still";
  bad.segment<2>(2) = good.segment<2>(2);
  ASSERT_EQ(map.move_to(bad), 0u);
  map.differentiate(map.all());
  expect_as_the_whole(map, bad);
}

TEST_F(BlockMapTest, FailedWholeMapKeepsAll) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  BlockMap map(*finger);
  ASSERT_EQ(map.move_to(random_pose().segment<2>(2)), 0u);
  const VecX before = map.x_probe();
  ASSERT_EQ(map.move_to((VecQ(2) << 0.02, -101 * kDegree).finished()), 1u);
  EXPECT_EQ(map.x_probe(), before);
}

TEST_F(BlockMapTest, QuaternionsBeginWithoutATurn) {
  const auto stylus = make_stylus({});
  EXPECT_EQ(BlockMap(*stylus).x_probe(), (VecX(7) << 0, 0, 0, 0, 0, 0, 1).finished());
  EXPECT_EQ(BlockMap(hand).x_probe(), VecX::Zero(10));
}

TEST_F(BlockMapTest, CopiesAndClearsBlocksAskedFor) {
  const BlockMap map(hand);
  const VecX from = VecX::LinSpaced(10, 1.0, 10.0);
  VecQ q = VecQ::Zero(10);
  map.copy_q(set_of({0, 3}), VecQ(from), q);
  EXPECT_EQ(q, (VecQ(10) << 1, 2, 0, 0, 0, 0, 7, 8, 0, 0).finished());
  VecX x = VecX::Zero(10);
  map.copy_x(set_of({1, 4}), from, x);
  EXPECT_EQ(x, (VecX(10) << 0, 0, 3, 4, 0, 0, 0, 0, 9, 10).finished());
  map.clear_x(set_of({4}), x);
  EXPECT_EQ(x, (VecX(10) << 0, 0, 3, 4, 0, 0, 0, 0, 0, 0).finished());
}

TEST_F(BlockMapTest, PlanesReachFingersTheyName) {
  const BlockMap map(hand);
  PlaneSet planes;
  EXPECT_EQ(map.reached(planes), 0u);
  planes.normals.setZero(10, 3);
  planes.offsets.setOnes(3);
  EXPECT_EQ(map.reached(planes), 0u) << "without a direction";
  planes.normals(3, 0) = 1.0;
  planes.normals(8, 1) = -1e-300;
  planes.normals(2, 2) = 0.5;
  EXPECT_EQ(map.reached(planes), set_of({1, 4}));
}

TEST_F(BlockMapTest, NeverAllocates) {
  BlockMap map(hand);
  const VecQ q = random_pose(), other = random_pose();
  VecX dx = VecX::Zero(10);
  dx[5] = -1e-300;
  const test::AllocationGuard guard;
  for (const VecQ& at : {q, other}) {
    EXPECT_EQ(map.move_to(at), 0u);
    map.differentiate(map.displaced(dx));
  }
  EXPECT_EQ(guard.allocations(), 0u);
  EXPECT_EQ(map.displaced(dx), 1u << 2);
}

TEST(Kinematics, PositionGivesTheBitsOfEvaluate) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const auto hand = make_hand_exoskeleton(five_fingers());
  const auto tracked = make_tracked_hand(five_fingers_on_a_palm());
  std::mt19937_64 random(3);
  for (const Kinematics* map :
       std::initializer_list<const Kinematics*>{finger.get(), hand.get(), tracked.get()}) {
    int compared = 0;
    for (int trial = 0; trial < 3000; ++trial) {
      VecQ q(map->layout().n_q());
      for (int i = 0; i < q.size(); ++i) {
        const DofSpec& dof = map->dofs()[static_cast<std::size_t>(i)];
        q[i] = std::uniform_real_distribution<double>(dof.lower, dof.upper)(random);
      }
      VecX x, alone;
      MatXQ J;
      const MapStatus status = map->evaluate(q, x, J);
      ASSERT_EQ(map->position(q, alone), status);
      if (status != MapStatus::kOk) continue;
      ASSERT_EQ(x, alone);
      ++compared;
    }
    EXPECT_GT(compared, 100);
  }
}

/// A Jacobian that must not be looked at is full of NaN here.
TEST_F(BlockMapTest, IdleFingersJacobianIsNotRead) {
  const VecA stiffness = VecA::LinSpaced(5, 800, 2000);
  for (const RendererKind kind : kEveryRenderer) {
    SCOPED_TRACE(std::string(name(kind)));
    BlockRenderer renderer(kind, hand.whole()), active_alone(kind, hand.whole());
    DirectionGuard guard(hand.whole(), stiffness);
    for (int trial = 0; trial < 20; ++trial) {
      const VecQ q = random_pose();
      VecX x_probe, x;
      MatXQ J;
      ASSERT_EQ(hand.evaluate(q, x_probe, J), MapStatus::kOk);
      x = x_probe;
      x.segment<2>(2) += (VecX(2) << -0.1, -0.15).finished();
      const VecX dx = x - x_probe;
      Projection all, active;
      renderer.project({q, x_probe, J}, x, dx, stiffness, true, all);
      MatXQ holes = J;
      for (const int idle : {0, 4, 6, 8}) holes.block<2, 2>(idle, idle).setConstant(kNaN);
      active_alone.project({q, x_probe, holes}, x, dx, stiffness, true, active);
      EXPECT_EQ(active.q_star, all.q_star);
      EXPECT_NE(all.q_star[2], q[2]);
      for (const int idle : {0, 4, 6, 8}) {  // Eq. (6) holds q* of x, within rounding of q
        EXPECT_NEAR(active.q_star[idle], q[idle], 1e-14);
        const bool to_the_bit = active.q_star[idle] == q[idle];
        EXPECT_TRUE(to_the_bit || kind == RendererKind::kSubspaceExact);
      }
      const VecA tau = stiffness.cwiseProduct(hand.layout().select(all.q_star - q));
      EXPECT_EQ(guard.allows({q, x_probe, holes}, dx, tau), guard.allows({q, x_probe, J}, dx, tau));
      EXPECT_EQ(renderer.reads_J(1u << 1) & ~BlockSet{1u << 1}, 0u);
    }
  }
}

/// S J^+ of a block diagonal J by one dense solve is the independent word on the guard's blocks.
TEST_F(BlockMapTest, GuardByBlocksEqualsDenseSolve) {
  std::normal_distribution<double> normal;
  DirectionGuard guard(hand.whole());
  int allowed = 0, withheld = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const VecQ q = random_pose();
    VecX x_probe, dx(10);
    MatXQ J;
    ASSERT_EQ(hand.evaluate(q, x_probe, J), MapStatus::kOk);
    for (int i = 0; i < 10; ++i) dx[i] = trial % 3 == 0 && i < 4 ? 0.0 : 0.1 * normal(random_);
    VecA tau(5);
    for (int i = 0; i < 5; ++i) tau[i] = normal(random_);
    const Eigen::VectorXd dq = oracle::least_squares(J, dx);
    const double towards = tau.dot(hand.layout().select(VecQ(dq)));
    if (std::abs(towards) < 1e-9) continue;
    EXPECT_EQ(guard.allows({q, x_probe, J}, dx, tau), towards > 0.0);
    ++(towards > 0.0 ? allowed : withheld);
  }
  EXPECT_GT(allowed, 50);
  EXPECT_GT(withheld, 50);
}

/// The same rule as for fingers side by side: one contact that is pushed in would take the force of
/// all.
TEST_F(BlockMapTest, TrackedHandIsJudgedBySum) {
  const auto tracked = make_tracked_hand(five_fingers_on_a_palm());
  std::normal_distribution<double> normal;
  DirectionGuard guard(*tracked);
  int allowed = 0, withheld = 0;
  for (int trial = 0; trial < 300; ++trial) {
    VecQ q = VecQ::Zero(16);
    q.tail(10) = random_pose();
    VecX x_probe, dx(33);
    MatXQ J;
    ASSERT_EQ(tracked->evaluate(q, x_probe, J), MapStatus::kOk);
    for (int i = 0; i < 33; ++i) dx[i] = 0.01 * normal(random_);
    VecA tau(5);
    for (int i = 0; i < 5; ++i) tau[i] = normal(random_);
    Contacts contacts;
    contacts.into = PlaneSet::Normals::Random(33, 8);
    contacts.into.colwise().normalize();
    contacts.depth = PlaneSet::Offsets::Constant(8, 0.1);
    const double towards = tau.dot(tracked->layout().select(VecQ(oracle::least_squares(J, dx))));
    if (std::abs(towards) < 1e-9) continue;
    EXPECT_EQ(guard.allows({q, x_probe, J, {&contacts}}, dx, tau), towards > 0.0);
    ++(towards > 0.0 ? allowed : withheld);
  }
  EXPECT_GT(allowed, 50);
  EXPECT_GT(withheld, 50);
}

}  // namespace
}  // namespace haptic::core
