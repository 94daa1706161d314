#include "haptic/core/rendering/block_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <random>

#include "haptic/core/model/stylus.hpp"
#include "haptic/core/passivity/direction_guard.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

constexpr BlockSet set_of(std::initializer_list<int> blocks) {
  BlockSet set = 0;
  for (const int block : blocks) set |= BlockSet{1} << block;
  return set;
}

const Kinematics& five_fingered() {
  static const auto hand = make_hand_exoskeleton(five_fingers());
  return *hand;
}

/// The hand, each finger counting.
class CountingHand final : public samples::Wrapped {
 public:
  CountingHand() : Wrapped(five_fingered()) {
    for (const MapBlock& block : five_fingered().blocks()) {
      blocks_.push_back(block);
      blocks_.back().kinematics = &fingers.emplace_back(*block.kinematics);
    }
  }
  std::deque<samples::Wrapped> fingers{};
  std::span<const MapBlock> blocks() const noexcept override { return blocks_; }

 private:
  std::vector<MapBlock> blocks_{};
};

class BlockMapTest : public ::testing::Test {
 protected:
  VecQ random_pose() {
    std::uniform_real_distribution<double> angle(15 * kDegree, 45 * kDegree);
    VecX x(10);
    for (int i = 0; i < 10; ++i) x[i] = angle(random_);
    VecQ q;
    EXPECT_EQ(five_fingered().inverse(x, q), InverseStatus::kExact);
    return q;
  }
  /// All of `map` at q has the bits of `whole`.
  static void expect_as_the_whole(BlockMap& map, const Kinematics& whole, const VecQ& q) {
    ASSERT_EQ(map.move_to(q), 0u);
    map.differentiate(map.all());
    const Instant at(whole, q, map.x_probe());
    EXPECT_EQ(map.x_probe(), at.x_probe);
    EXPECT_EQ(map.J(), at.J);
  }
  std::mt19937_64 random_{7};
  CountingHand hand;
};

TEST_F(BlockMapTest, EqualsWholeMapToTheBit) {
  BlockMap map(hand);
  for (int trial = 0; trial < 50; ++trial) expect_as_the_whole(map, hand, random_pose());
  const auto finger = make_finger_exoskeleton(finger_sign_change());  // a map without blocks
  BlockMap single(*finger);
  expect_as_the_whole(single, *finger, random_pose().segment<2>(2));
}

TEST_F(BlockMapTest, EvaluatesOnlyWhatIsNeeded) {
  BlockMap map(hand);
  VecQ q = random_pose();
  constexpr BlockSet kIndex = 1u << 1;
  ASSERT_EQ(map.move_to(q), 0u);
  map.differentiate(kIndex);
  for (samples::Wrapped& finger : hand.fingers) finger.positions = finger.evaluations = 0;
  for (int tick = 0; tick < 10; ++tick) {
    q[2] += 1e-4;  // the index moves and presses,
    q[4] += 1e-4;  // the middle moves freely,
    ASSERT_EQ(map.move_to(q), 0u);
    map.differentiate(kIndex);
    const Instant at(hand, q, map.x_probe());
    EXPECT_EQ(map.x_probe(), at.x_probe);
    EXPECT_EQ((map.J().block<2, 2>(2, 2)), (at.J.block<2, 2>(2, 2)));
  }
  EXPECT_EQ(hand.fingers[1].evaluations, 10);
  EXPECT_EQ(hand.fingers[1].positions, 0);
  EXPECT_EQ(hand.fingers[2].evaluations, 0);
  EXPECT_EQ(hand.fingers[2].positions, 10);
  for (const std::size_t rests : {0u, 3u, 4u}) {
    EXPECT_EQ(hand.fingers[rests].evaluations + hand.fingers[rests].positions, 0);
  }
  // And a finger that comes to need it gets it in the same tick.
  expect_as_the_whole(map, hand, q);
}

TEST_F(BlockMapTest, FailedFingerKeepsLastOthersMove) {
  BlockMap map(hand);
  const VecQ good = random_pose();
  expect_as_the_whole(map, hand, good);
  const VecX before = map.x_probe();
  VecQ bad = random_pose();
  bad.segment<2>(2) << 0.02, -101 * kDegree;  // core/METHOD.md#map-without-a-value
  ASSERT_EQ(map.move_to(bad), set_of({1}));
  EXPECT_EQ(VecX(map.x_probe().segment(2, 2)), VecX(before.segment(2, 2)));
  VecQ others = bad;
  others.segment<2>(2) = good.segment<2>(2);
  EXPECT_EQ(map.x_probe(), Instant(hand, others, before).x_probe);
  EXPECT_EQ(map.move_to(bad), set_of({1})) << "still";
  expect_as_the_whole(map, hand, others);
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

TEST_F(BlockMapTest, TellsDisplacedFingers) {
  VecX dx = VecX::Zero(10);
  dx[5] = -1e-300;
  EXPECT_EQ(BlockMap(hand).displaced(dx), 1u << 2);
}

TEST(Kinematics, PositionGivesTheBitsOfEvaluate) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const auto hand = make_hand_exoskeleton(five_fingers());
  const auto tracked = make_tracked_hand(five_fingers_on_a_palm());
  for (const Kinematics* map :
       std::initializer_list<const Kinematics*>{finger.get(), hand.get(), tracked.get()}) {
    int compared = 0;
    for (int trial = 0; trial < 3000; ++trial) {
      const VecQ q = workspace_sample(*map, trial);
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

/// S J^+ of the whole J by one dense solve is the independent word on the guard's blocks. On a
/// tracked palm contacts do not count either: one that is pushed in would take the force of all.
TEST_F(BlockMapTest, GuardJudgesTheSumOfFingers) {
  const auto tracked = make_tracked_hand(five_fingers_on_a_palm());
  std::normal_distribution<double> normal;
  for (const Kinematics* map : {&five_fingered(), static_cast<const Kinematics*>(tracked.get())}) {
    DirectionGuard guard(*map);
    const bool palm = map == tracked.get();
    const int n_x = map->space().n_x();
    int allowed = 0, withheld = 0;
    for (int trial = 0; trial < 300; ++trial) {
      VecQ q = VecQ::Zero(map->layout().n_q());
      q.tail(10) = random_pose();
      const Instant at(*map, q, VecX::Zero(n_x));
      VecX dx(n_x);
      for (double& part : dx) part = 0.1 * normal(random_);
      if (trial % 3 == 0 && !palm) dx.head(4).setZero();
      VecA tau(5);
      for (double& part : tau) part = normal(random_);
      Contacts contacts;
      contacts.into = PlaneSet::Normals::Random(n_x, 8);
      contacts.into.colwise().normalize();
      contacts.depth = PlaneSet::Offsets::Constant(8, 0.1);
      const Probe probe = palm ? at.probe({&contacts}) : at.probe();
      const double towards = tau.dot(map->layout().select(VecQ(oracle::least_squares(at.J, dx))));
      if (std::abs(towards) < 1e-9) continue;
      EXPECT_EQ(guard.share(probe, dx, tau) > 0.0, towards > 0.0);
      ++(towards > 0.0 ? allowed : withheld);
    }
    EXPECT_GT(allowed, 50);
    EXPECT_GT(withheld, 50);
  }
}

}  // namespace
}  // namespace haptic::core
