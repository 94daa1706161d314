#include "haptic/core/model/hand_exoskeleton.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "haptic/core/error.hpp"
#include "tests/core/model/derivatives.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::core {
namespace {

/// Joint angles of all fingers well inside the valid region (core/METHOD.md#finger-linkage).
VecX random_joints(std::mt19937_64& random, int fingers) {
  std::uniform_real_distribution<double> mcp(15 * kDegree, 45 * kDegree);
  std::uniform_real_distribution<double> pip(20 * kDegree, 60 * kDegree);
  VecX x(2 * fingers);
  for (int i = 0; i < fingers; ++i) x.segment<2>(2 * i) << mcp(random), pip(random);
  return x;
}

VecQ reach(const Kinematics& map, const VecX& x) {
  VecQ q;
  EXPECT_EQ(map.inverse(x, q), InverseStatus::kExact);
  return q;
}

TEST(ScaledFinger, KeepsItsAngles) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const auto large = make_finger_exoskeleton(scaled(finger_sign_change(), 1.3));
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    VecQ q = reach(*finger, random_joints(random, 1));
    VecX x, x_large;
    MatXQ J, J_large;
    ASSERT_EQ(finger->evaluate(q, x, J), MapStatus::kOk);
    q[0] *= 1.3;
    ASSERT_EQ(large->evaluate(q, x_large, J_large), MapStatus::kOk);
    EXPECT_LT((x_large - x).norm(), 1e-14);
    EXPECT_LT((1.3 * J_large.col(0) - J.col(0)).norm(), 1e-12 * J.col(0).norm());
    EXPECT_LT((J_large.col(1) - J.col(1)).norm(), 1e-12 * J.col(1).norm());
  }
}

TEST(HandExoskeleton, NamesEachFingersDofsAndCoordinates) {
  const auto hand = make_hand_exoskeleton(five_fingers());
  EXPECT_EQ(hand->layout().n_q(), 10);
  ASSERT_EQ(hand->layout().n_a(), 5);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(hand->layout().actuated(i), 2 * i);
  EXPECT_EQ(hand->dofs()[4].name, "middle.l_x");
  EXPECT_NEAR(hand->dofs()[4].upper, 0.055, 1e-15);
  EXPECT_EQ(hand->dofs()[9].name, "little.q_B");
  EXPECT_EQ(hand->space().coordinates()[3].name, "index.q_o2_pip");
  EXPECT_FALSE(hand->space().mixes_units());
}

TEST(HandExoskeleton, IsItsFingersSideBySide) {
  const auto hand = make_hand_exoskeleton(five_fingers());
  ASSERT_EQ(hand->blocks().size(), 5u);
  std::vector<std::unique_ptr<Kinematics>> alone;
  for (const HandFinger& finger : five_fingers())
    alone.push_back(make_finger_exoskeleton(finger.dimensions));
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const VecX goal = random_joints(random, 5);
    const VecQ q = reach(*hand, goal);
    VecX x, x_finger;
    MatXQ J, J_finger;
    ASSERT_EQ(hand->evaluate(q, x, J), MapStatus::kOk);
    EXPECT_LT((x - goal).norm(), 1e-12);
    Eigen::MatrixXd rest = J;
    for (std::size_t i = 0; i < 5; ++i) {
      const auto& finger = alone[i];
      const int at = 2 * static_cast<int>(i);
      EXPECT_EQ(hand->blocks()[i].first_q, at);
      EXPECT_EQ(hand->blocks()[i].first_x, at);
      EXPECT_EQ(hand->blocks()[i].first_a, static_cast<int>(i));
      const VecQ part = q.segment<2>(at);
      ASSERT_EQ(finger->evaluate(part, x_finger, J_finger), MapStatus::kOk);
      EXPECT_EQ(VecX(x.segment<2>(at)), x_finger);
      EXPECT_TRUE((J.block<2, 2>(at, at) == J_finger));
      rest.block<2, 2>(at, at).setZero();
    }
    EXPECT_EQ(rest.norm(), 0.0) << "block by block";
  }
}

TEST(HandExoskeleton, OneUnreachableFingerLeavesOthersExact) {
  const auto hand = make_hand_exoskeleton(five_fingers());
  std::mt19937_64 random(4);
  VecX x = random_joints(random, 5);
  const VecQ reached = reach(*hand, x);
  x.segment<2>(4) << -0.7, 0.35;  // tests/report/STUDY.md#unreachable-proxies
  VecQ q;
  EXPECT_EQ(hand->inverse(x, q), InverseStatus::kUnreachable);
  for (int i = 0; i < 10; ++i) {
    if (i == 4 || i == 5) continue;
    EXPECT_EQ(q[i], reached[i]) << i;
  }
  // tests/report/STUDY.md#unreachable-proxies: at (10.15 mm, 41.5 deg)
  EXPECT_NEAR(q[4], 0.01015 * 1.1, 2e-4);
  EXPECT_NEAR(q[5], 41.5 * kDegree, 1e-9);
}

/// core/METHOD.md#map-without-a-value, of one finger.
TEST(HandExoskeleton, FailsIfOneFingerCannotClose) {
  const auto hand = make_hand_exoskeleton(five_fingers());
  std::mt19937_64 random(5);
  VecQ q = reach(*hand, random_joints(random, 5));
  VecX x;
  MatXQ J;
  ASSERT_EQ(hand->evaluate(q, x, J), MapStatus::kOk);
  const VecX before = x;
  q.segment<2>(2) << 0.0298, -1.998;  // D falls on the MCP axis, closer than rod 1 is long
  EXPECT_EQ(hand->evaluate(q, x, J), MapStatus::kCannotClose);
  EXPECT_EQ(x, before) << "untouched";
  EXPECT_EQ(hand->evaluate(VecQ::Zero(4), x, J), MapStatus::kCannotClose);
}

TEST(HandExoskeleton, SaysWhichFingerIsWrong) {
  const auto said = [](const std::vector<HandFinger>& fingers) {
    return haptic::test::message_of<SceneError>([&] { return make_hand_exoskeleton(fingers); });
  };
  EXPECT_EQ(said({}), "hand with 0 fingers: must have 1 to 12");
  EXPECT_EQ(said({{"a", {}}, {"a", {}}}), "finger a given twice: names must differ");
  EXPECT_EQ(said({{"", {}}}), "a finger's name is empty: must be given");
  FingerDimensions bad = finger_sign_change();
  bad.rod1 = -1.0;
  EXPECT_EQ(said({{"a", {}}, {"b", bad}}),
            "finger b: finger_exoskeleton.rod1_m = -1.000000: must be finite and > 0");
}

// --- on a tracked palm ---------------------------------------------------------------------------

VecQ hand_pose(std::mt19937_64& random, const VecQ& fingers, double turn = 1.5) {
  std::uniform_real_distribution<double> metres(-0.3, 0.3), radians(-turn, turn);
  VecQ q(6 + fingers.size());
  for (int i = 0; i < 3; ++i) {
    q[i] = metres(random);
    q[3 + i] = radians(random);
  }
  q.tail(fingers.size()) = fingers;
  return q;
}

TEST(TrackedHand, SensesPalmAndDrivesFingers) {
  const auto hand = make_tracked_hand(five_fingers_on_a_palm());
  EXPECT_EQ(hand->layout().n_q(), 16);
  ASSERT_EQ(hand->layout().n_a(), 5);
  EXPECT_EQ(hand->layout().actuated(0), 6);
  EXPECT_EQ(hand->space().n_x(), 33) << "dim X > dim Q";
  EXPECT_TRUE(hand->blocks().empty()) << "the palm moves them all";
  EXPECT_EQ(hand->dofs()[3].name, "palm.rx");
  EXPECT_EQ(hand->dofs()[8].name, "index.l_x");
  EXPECT_EQ(hand->space().coordinates()[6].name, "index_tip.x");
}

/// Points of the plane of core/METHOD.md#finger-linkage, turned and moved by the palm.
TEST(TrackedHand, PalmMovesThePhalangesRigidly) {
  const TrackedHandParameters parameters = five_fingers_on_a_palm();
  const auto hand = make_tracked_hand(parameters);
  const auto plain = make_hand_exoskeleton(five_fingers());
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 100; ++trial) {
    const VecX angles = random_joints(random, 5);
    const VecQ q = hand_pose(random, reach(*plain, angles));
    VecX x;
    MatXQ J;
    ASSERT_EQ(hand->evaluate(q, x, J), MapStatus::kOk);
    const Eigen::Vector3d phi = q.segment<3>(3), p = q.head<3>();
    const Eigen::AngleAxisd palm(phi.norm(), phi.normalized());
    for (int i = 0; i < 5; ++i) {
      const MountedFinger& mounted = parameters.fingers[static_cast<std::size_t>(i)];
      const double L1 = mounted.finger.dimensions.proximal_phalanx;
      const double q1 = angles[2 * i], phi2 = q1 + angles[2 * i + 1];
      // u = e^{-i q1} and its dorsal normal i u, core/METHOD.md#finger-linkage.
      const Eigen::Vector3d u1(std::cos(q1), -std::sin(q1), 0), n1(std::sin(q1), std::cos(q1), 0);
      const Eigen::Vector3d u2(std::cos(phi2), -std::sin(phi2), 0);
      const Eigen::Vector3d n2(std::sin(phi2), std::cos(phi2), 0);
      const Pose3& m = mounted.mount;
      const Eigen::Quaterniond turn(m.orientation.w, m.orientation.x, m.orientation.y,
                                    m.orientation.z);
      const auto world = [&](const Eigen::Vector3d& in_finger) -> Eigen::Vector3d {
        const Eigen::Vector3d at(m.position.x, m.position.y, m.position.z);
        return p + palm * (at + turn * in_finger);
      };
      const Eigen::Vector3d tip = world(L1 * u1 + 0.03 * u2 - 0.008 * n2);
      const Eigen::Vector3d pad = world(0.025 * u1 - 0.01 * n1);
      EXPECT_LT((x.segment<3>(6 * i) - tip).norm(), 1e-13);
      EXPECT_LT((x.segment<3>(6 * i + 3) - pad).norm(), 1e-13);
    }
  }
}

TEST(TrackedHand, JacobianMatchesCentralDifferences) {
  std::mt19937_64 random(7);
  const auto plain = make_hand_exoskeleton(five_fingers());
  for (const OutputKind kind : {OutputKind::kPoint, OutputKind::kFrame}) {
    const auto hand = make_tracked_hand(five_fingers_on_a_palm(kind));
    for (int trial = 0; trial < 100; ++trial) {
      const VecQ q = hand_pose(random, reach(*plain, random_joints(random, 5)));
      EXPECT_LT(jacobian_error(*hand, q), 2e-7);
    }
  }
}

TEST(Hands, TellTheMechanismOfEachPair) {
  const auto hand = make_hand_exoskeleton(five_fingers());
  const auto tracked = make_tracked_hand(five_fingers_on_a_palm());
  for (const Kinematics* map : {hand.get(), tracked.get()}) {
    ASSERT_EQ(map->mechanisms().size(), 5u);
    for (int i = 0; i < 5; ++i) {
      const Kinematics& finger = *map->mechanisms()[static_cast<std::size_t>(i)].kinematics;
      const double size =
          five_fingers()[static_cast<std::size_t>(i)].dimensions.rod1 / finger_sign_change().rod1;
      EXPECT_EQ(finger.layout().n_q(), 2);
      EXPECT_NEAR(finger.dofs()[0].upper, size * finger_sign_change().l_x_upper, 1e-15) << i;
    }
  }
  const auto one = make_finger_exoskeleton({});
  EXPECT_EQ(one->mechanisms()[0].kinematics, one.get()) << "a finger is its own";
}

TEST(TrackedHand, NamesTheScenesMistake) {
  const auto with = [](auto change) -> std::string {
    TrackedHandParameters parameters = five_fingers_on_a_palm();
    change(parameters);
    return haptic::test::message_of<SceneError>([&] { return make_tracked_hand(parameters); });
  };
  using P = TrackedHandParameters;
  EXPECT_EQ(with([](P&) {}), "no error");
  EXPECT_EQ(with([](P& p) { p.fingers.clear(); }), "tracked hand with 0 fingers: must have 1 to 9");
  EXPECT_EQ(with([](P& p) { p.outputs[2].finger = "toe"; }),
            "output index_tip.finger = toe: must be one of the hand's");
  EXPECT_EQ(with([](P& p) { p.outputs[2].name = "thumb_tip"; }),
            "output thumb_tip given twice: names must differ");
  EXPECT_EQ(
      with([](P& p) {
        p.fingers[1].mount.orientation = {0, 0, 0, 0};
      }),
      "finger index.mount.orientation of norm 0.000000: must be a quaternion other than zero");
  EXPECT_EQ(with([](P& p) { p.palm.position_lower = 2.0; }),
            "palm.position from 2.000000 to 1.000000 m: both must be finite, lower < upper");
  EXPECT_NE(with([](P& p) { p.outputs.clear(); }), "no error");
}

}  // namespace
}  // namespace haptic::core
