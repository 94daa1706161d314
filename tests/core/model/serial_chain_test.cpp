#include "haptic/core/model/serial_chain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <random>

#include "haptic/core/error.hpp"
#include "tests/core/model/derivatives.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/kdl_chain.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::core {
namespace {

using test::kdl;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double within(double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(engine_);
  }
  bool one_in(int n) { return std::uniform_int_distribution<int>(1, n)(engine_) == 1; }
  Point3 point(double reach) {
    return {within(-reach, reach), within(-reach, reach), within(-reach, reach)};
  }
  Pose3 pose(double reach) {
    const UnitQuaternion q{within(-1, 1), within(-1, 1), within(-1, 1), within(-1, 1)};
    return {point(reach), q};
  }

 private:
  std::mt19937_64 engine_;
};

/// n joints in a row, a third of them prismatic, with a frame beyond the last one.
SerialChainParameters random_chain(Random& random, int n) {
  SerialChainParameters chain;
  for (int i = 0; i < n; ++i) {
    ChainJoint joint;
    joint.name = "j" + std::to_string(i);
    const bool prismatic = random.one_in(3);
    joint.kind = prismatic ? JointKind::kPrismatic : JointKind::kRevolute;
    joint.origin = random.pose(0.3);
    joint.axis = random.point(1.0);
    joint.lower = prismatic ? -0.2 : -3.0;
    joint.upper = prismatic ? 0.3 : 2.5;
    chain.joints.push_back(joint);
  }
  chain.outputs = {{"tip", "", OutputKind::kFrame, random.pose(0.2)}};
  return chain;
}

/// A palm with two branches of two joints and a spur, points and frames all over it.
SerialChainParameters branched_chain(Random& random, bool palm) {
  SerialChainParameters chain = random_chain(random, 5);
  if (palm) chain.palm = TrackedPalm{};
  chain.joints[2].parent = "base";
  chain.joints[4].parent = "j0";
  chain.outputs = {{"a", "j1", OutputKind::kFrame, random.pose(0.1)},
                   {"b", "j3", OutputKind::kPoint, random.pose(0.1)},
                   {"c", "j4", OutputKind::kFrame, random.pose(0.1)}};
  if (palm) chain.outputs.push_back({"wrist", "base", OutputKind::kFrame, random.pose(0.1)});
  return chain;
}

/// f by KDL's recursion; J is held to f by central differences below.
TEST(SerialChain, AgreesWithKdlOnRandomChains) {
  Random random(1);
  double worst = 0.0;
  for (int trial = 0; trial < 300; ++trial) {
    const SerialChainParameters parameters = random_chain(random, 1 + trial % 9);
    const auto chain = make_serial_chain(parameters);
    const KDL::Chain reference = kdl(parameters);
    for (int s = 0; s < 5; ++s) {
      const VecQ q = workspace_sample(*chain, 7 * s + trial);
      VecX x, expected(7);
      ASSERT_EQ(chain->position(q, x), MapStatus::kOk);
      KDL::JntArray at(static_cast<unsigned>(q.size()));
      at.data = q;
      KDL::Frame tip;
      ASSERT_GE(KDL::ChainFkSolverPos_recursive(reference).JntToCart(at, tip), 0);
      expected.head<3>() << tip.p.x(), tip.p.y(), tip.p.z();
      tip.M.GetQuaternion(expected[3], expected[4], expected[5], expected[6]);
      // Q and -Q are one rotation.
      if (expected.tail<4>().dot(x.tail<4>()) < 0.0) expected.tail<4>() *= -1.0;
      worst = std::max(worst, (x - expected).cwiseAbs().maxCoeff());
    }
  }
  // KDL keeps rotations as matrices, hence rounding of a few eps times the number of joints.
  EXPECT_LT(worst, 1e-13);
}

TEST(SerialChain, JacobianMatchesCentralDifferences) {
  Random random(2);
  double worst = 0.0;
  for (int trial = 0; trial < 200; ++trial) {
    const auto chain = make_serial_chain(branched_chain(random, trial % 2 == 0));
    for (int s = 0; s < 3; ++s) {
      worst = std::max(worst, jacobian_error(*chain, workspace_sample(*chain, 11 * trial + s)));
    }
  }
  EXPECT_LT(worst, 2e-7);  // tests/report/STUDY.md#derivatives
}

TEST(SerialChain, PalmJacobianIsSmoothThroughPi) {
  Random random(8);
  const auto chain = make_serial_chain(branched_chain(random, true));
  const Eigen::Vector3d axis = Eigen::Vector3d(-2, 1, 3).normalized();
  for (const double theta : {0.0, 1e-12, 1e-6, 1e-3, 0.1, 0.1999, 0.2001, 1.0, kPi, 4.0}) {
    VecQ q = workspace_sample(*chain, 5);
    q.segment<3>(3) = theta * axis;
    EXPECT_LT(jacobian_error(*chain, q), 2e-7) << theta;
  }
}

/// Three joints at right angles, worked out by hand: turn by 90 degrees, lift by 0.1, point out.
TEST(SerialChain, PlacesAHandWorkedArm) {
  SerialChainParameters parameters;
  ChainJoint turn{"turn", JointKind::kRevolute, true, "", {}, {0, 0, 2}, -2, 2};
  ChainJoint lift{"lift", JointKind::kPrismatic, false, "", {{0.2, 0, 0}, {}}, {0, 0, 1}, 0, 0.5};
  parameters.joints = {turn, lift};
  parameters.outputs = {{"tip", "", OutputKind::kPoint, {{0.3, 0, 0}, {}}},
                        {"elbow", "turn", OutputKind::kPoint, {{0.2, 0, 0}, {}}}};
  const auto chain = make_serial_chain(parameters);
  VecX x;
  MatXQ J;
  ASSERT_EQ(chain->evaluate((VecQ(2) << kPi / 2, 0.1).finished(), x, J), MapStatus::kOk);
  EXPECT_TRUE(x.isApprox((VecX(6) << 0, 0.5, 0.1, 0, 0.2, 0).finished(), 1e-15));
  EXPECT_TRUE(J.col(0).isApprox((VecX(6) << -0.5, 0, 0, -0.2, 0, 0).finished(), 1e-15));
  EXPECT_TRUE(J.col(1).isApprox((VecX(6) << 0, 0, 1, 0, 0, 0).finished(), 1e-15));
  EXPECT_EQ(chain->layout().n_a(), 1);
  EXPECT_EQ(chain->dofs()[1].unit, Unit::kMetre);
  EXPECT_EQ(chain->space().coordinates()[3].name, "elbow.x");
}

TEST(SerialChain, PalmTurnsByItsRotationVector) {
  Random random(4);
  SerialChainParameters parameters = branched_chain(random, true);
  parameters.outputs = {{"wrist", "base", OutputKind::kFrame, {}}};
  const auto chain = make_serial_chain(parameters);
  for (int trial = 0; trial < 200; ++trial) {
    VecQ q = workspace_sample(*chain, trial);
    VecX x;
    MatXQ J;
    ASSERT_EQ(chain->evaluate(q, x, J), MapStatus::kOk);
    const Eigen::Vector3d phi = q.segment<3>(3);
    const Eigen::AngleAxisd turn(phi.norm(), phi.normalized());
    const Eigen::Quaterniond Q(x[6], x[3], x[4], x[5]);
    EXPECT_NEAR(Q.norm(), 1.0, 1e-15);
    EXPECT_LT((Q.toRotationMatrix() - turn.toRotationMatrix()).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_EQ(x.head<3>(), VecX(q.head<3>()));
    // A turn more is the same pose, and the tracker's reading finds back to where q* is.
    VecQ turned = q;
    turned.segment<3>(3) *= 1.0 - 2.0 * kPi / phi.norm();
    chain->nearest_representative(q, turned);
    EXPECT_LT((turned - q).cwiseAbs().maxCoeff(), 1e-13);
  }
}

TEST(SerialChain, RefusesValuesThatAreNotFinite) {
  Random random(6);
  const auto chain = make_serial_chain(random_chain(random, 3));
  VecX x;
  MatXQ J;
  EXPECT_EQ(chain->evaluate((VecQ(3) << 0, NAN, 0).finished(), x, J), MapStatus::kCannotClose);
  EXPECT_EQ(chain->evaluate(VecQ::Zero(2), x, J), MapStatus::kCannotClose);
}

TEST(SerialChain, NamesTheScenesMistake) {
  Random random(7);
  const SerialChainParameters good = branched_chain(random, true);
  using P = SerialChainParameters;
  const struct {
    void (*change)(P&);
    const char* says;  ///< null: anything but that it is accepted
  } cases[] = {
      {[](P&) {}, "no error"},
      {[](P& p) { p.joints[1].name = "j0"; }, "joint j0 given twice: names must differ"},
      {[](P& p) { p.joints[1].name = ""; }, "a joint's name is empty: must be given"},
      {[](P& p) { p.joints[1].name = "base"; }, "joint base: the name is taken by the fixed frame"},
      {[](P& p) { p.joints[1].parent = "j4"; },
       "joint j1.parent = j4: must be \"base\" or a joint given before"},
      {[](P& p) {
         p.joints[1].axis = Point3{0, 0, 0};
       },
       "joint j1.axis of length 0.000000: must be finite and not zero"},
      {[](P& p) { p.joints[1].lower = p.joints[1].upper = 0.5; },
       "joint j1 from 0.500000 to 0.500000: both must be finite, lower < upper"},
      {[](P& p) {
         p.joints[1].origin.orientation = UnitQuaternion{0, 0, 0, 0};
       },
       "joint j1.origin.orientation of norm 0.000000: must be a quaternion other than zero"},
      {[](P& p) { p.joints[1].origin.position.y = NAN; },
       "joint j1.origin.position: must be finite"},
      {[](P& p) { p.outputs[1].link = "thumb"; },
       "output b.link = thumb: must be \"base\" or a joint given before"},
      {[](P& p) { p.outputs[1].name = "a"; }, "output a given twice: names must differ"},
      {[](P& p) { p.palm.reset(); }, "output wrist.link = base: nothing moves it"},
      {[](P& p) { p.outputs.clear(); }, nullptr},
      {[](P& p) { p.outputs.resize(12); }, nullptr},
      {[](P& p) { p.joints.clear(); }, nullptr},
      {[](P& p) { p.palm->position_upper = -2.0; }, nullptr},
      {[](P& p) {
         for (ChainJoint& joint : p.joints) joint.actuated = false;
       },
       nullptr},
      {[](P& p) {
         for (int i = 0; i < 20; ++i) {
           p.joints.push_back(p.joints[0]);
           p.joints.back().name = "more" + std::to_string(i);
         }
       },
       nullptr}};
  for (const auto& c : cases) {
    SerialChainParameters parameters = good;
    c.change(parameters);
    const std::string text =
        haptic::test::message_of<SceneError>([&] { return make_serial_chain(parameters); });
    if (c.says != nullptr) {
      EXPECT_EQ(text, c.says);
    } else {
      EXPECT_NE(text, "no error");
    }
  }
}

}  // namespace
}  // namespace haptic::core
