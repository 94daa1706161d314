#include "haptic/core/model/serial_chain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacdotsolver.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <random>

#include "haptic/core/error.hpp"
#include "tests/core/model/derivatives.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/kdl_chain.hpp"

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

using Quaternion = Eigen::Vector4d;  // x, y, z, w

/// 1/2 omega Q, written out.
Quaternion half_turn(const Eigen::Vector3d& w, const Quaternion& Q) {
  const Eigen::Vector3d v = Q.head<3>();
  Quaternion out;
  out << 0.5 * (Q[3] * w + w.cross(v)), -0.5 * w.dot(v);
  return out;
}

/// f, J and dJ/dq of one frame at the end, by KDL's recursions.
struct Oracle {
  VecX x{};
  MatXQ J{};
  std::vector<MatXQ> dJ{};

  Oracle(const KDL::Chain& chain, const VecQ& q) {
    const auto n = static_cast<unsigned>(q.size());
    KDL::JntArray at(n);
    at.data = q;
    KDL::Frame tip;
    EXPECT_GE(KDL::ChainFkSolverPos_recursive(chain).JntToCart(at, tip), 0);
    KDL::Jacobian twist(n), rate(n);
    EXPECT_GE(KDL::ChainJntToJacSolver(chain).JntToJac(at, twist), 0);
    Quaternion Q;
    tip.M.GetQuaternion(Q[0], Q[1], Q[2], Q[3]);
    x.resize(7);
    x << tip.p.x(), tip.p.y(), tip.p.z(), Q;
    J.resize(7, q.size());
    for (int k = 0; k < q.size(); ++k) {
      J.col(k) << twist.data.col(k).head<3>(), half_turn(twist.data.col(k).tail<3>(), Q);
    }
    KDL::ChainJntToJacDotSolver solver(chain);
    solver.setHybridRepresentation();
    for (unsigned k = 0; k < n; ++k) {
      KDL::JntArrayVel moving(n);
      moving.q = at;
      moving.qdot.data = Eigen::VectorXd::Unit(n, k);
      EXPECT_GE(solver.JntToJacDot(moving, rate), 0);
      const Quaternion dQ = half_turn(twist.data.col(k).tail<3>(), Q);
      MatXQ J_k(7, q.size());
      for (int i = 0; i < q.size(); ++i) {
        J_k.col(i) << rate.data.col(i).head<3>(),
            half_turn(rate.data.col(i).tail<3>(), Q) + half_turn(twist.data.col(i).tail<3>(), dQ);
      }
      dJ.push_back(J_k);
    }
  }

  /// Q and -Q are one rotation: the other sign.
  void flip() {
    x.tail<4>() *= -1.0;
    J.bottomRows<4>() *= -1.0;
    for (MatXQ& J_k : dJ) J_k.bottomRows<4>() *= -1.0;
  }
};

TEST(SerialChain, AgreesWithKdlOnRandomChains) {
  Random random(1);
  double f_worst = 0.0, J_worst = 0.0, dJ_worst = 0.0;
  for (int trial = 0; trial < 300; ++trial) {
    const SerialChainParameters parameters = random_chain(random, 1 + trial % 9);
    const auto chain = make_serial_chain(parameters);
    const KDL::Chain reference = kdl(parameters);
    for (int s = 0; s < 5; ++s) {
      const VecQ q = workspace_sample(*chain, 7 * s + trial);
      VecX x;
      MatXQ J, J_k;
      ASSERT_EQ(chain->evaluate(q, x, J), MapStatus::kOk);
      Oracle oracle(reference, q);
      if (oracle.x.tail<4>().dot(x.tail<4>()) < 0.0) oracle.flip();
      f_worst = std::max(f_worst, (x - oracle.x).cwiseAbs().maxCoeff());
      J_worst = std::max(J_worst, (J - oracle.J).cwiseAbs().maxCoeff());
      for (int k = 0; k < q.size(); ++k) {
        ASSERT_EQ(chain->second_order(q, k, J_k), MapStatus::kOk);
        const MatXQ& expected = oracle.dJ[static_cast<std::size_t>(k)];
        dJ_worst = std::max(dJ_worst, (J_k - expected).cwiseAbs().maxCoeff());
      }
    }
  }
  // KDL keeps rotations as matrices, hence rounding of a few eps times the number of joints.
  EXPECT_LT(f_worst, 1e-13);
  EXPECT_LT(J_worst, 1e-13);
  EXPECT_LT(dJ_worst, 1e-13);
}

TEST(SerialChain, DerivativesMatchCentralDifferences) {
  Random random(2);
  DerivativeErrors worst;
  for (int trial = 0; trial < 200; ++trial) {
    const auto chain = make_serial_chain(branched_chain(random, trial % 2 == 0));
    for (int s = 0; s < 3; ++s) {
      const DerivativeErrors e =
          derivative_errors(*chain, workspace_sample(*chain, 11 * trial + s));
      worst = {std::max(worst.J, e.J), std::max(worst.dJ, e.dJ)};
    }
  }
  EXPECT_LT(worst.J, 2e-7);  // tests/report/STUDY.md#derivatives
  EXPECT_LT(worst.dJ, 5e-7);
}

TEST(SerialChain, PalmDerivativesAreSmoothThroughPi) {
  Random random(8);
  const auto chain = make_serial_chain(branched_chain(random, true));
  const Eigen::Vector3d axis = Eigen::Vector3d(-2, 1, 3).normalized();
  for (const double theta : {0.0, 1e-12, 1e-6, 1e-3, 0.1, 0.1999, 0.2001, 1.0, kPi, 4.0}) {
    VecQ q = workspace_sample(*chain, 5);
    q.segment<3>(3) = theta * axis;
    const DerivativeErrors e = derivative_errors(*chain, q);
    EXPECT_LT(e.J, 2e-7) << theta;
    EXPECT_LT(e.dJ, 5e-7) << theta;
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

TEST(SerialChain, NeverAllocates) {
  Random random(5);
  const auto chain = make_serial_chain(branched_chain(random, true));
  VecQ q = workspace_sample(*chain, 3);
  VecX x;
  MatXQ J;
  const test::AllocationGuard guard;
  ASSERT_EQ(chain->evaluate(q, x, J), MapStatus::kOk);
  for (int k = 0; k < q.size(); ++k) ASSERT_EQ(chain->second_order(q, k, J), MapStatus::kOk);
  chain->nearest_representative(x.head(q.size()), q);
  EXPECT_EQ(guard.allocations(), 0u);
}

TEST(SerialChain, RefusesValuesThatAreNotFinite) {
  Random random(6);
  const auto chain = make_serial_chain(random_chain(random, 3));
  VecX x;
  MatXQ J;
  EXPECT_EQ(chain->evaluate((VecQ(3) << 0, NAN, 0).finished(), x, J), MapStatus::kCannotClose);
  EXPECT_EQ(chain->evaluate(VecQ::Zero(2), x, J), MapStatus::kCannotClose);
}

std::string refusal(const SerialChainParameters& parameters) {
  try {
    static_cast<void>(make_serial_chain(parameters));
  } catch (const SceneError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SerialChain, NamesTheScenesMistake) {
  Random random(7);
  const SerialChainParameters good = branched_chain(random, true);
  ASSERT_EQ(refusal(good), "accepted");
  const auto with = [&](auto change) {
    SerialChainParameters bad = good;
    change(bad);
    return refusal(bad);
  };
  using P = SerialChainParameters;
  EXPECT_EQ(with([](P& p) { p.joints[1].name = "j0"; }), "joint j0 given twice: names must differ");
  EXPECT_EQ(with([](P& p) { p.joints[1].name = ""; }), "a joint's name is empty: must be given");
  EXPECT_EQ(with([](P& p) { p.joints[1].name = "base"; }),
            "joint base: the name is taken by the fixed frame");
  EXPECT_EQ(with([](P& p) { p.joints[1].parent = "j4"; }),
            "joint j1.parent = j4: must be \"base\" or a joint given before");
  EXPECT_EQ(with([](P& p) {
              p.joints[1].axis = {0, 0, 0};
            }),
            "joint j1.axis of length 0.000000: must be finite and not zero");
  EXPECT_EQ(with([](P& p) { p.joints[1].lower = p.joints[1].upper = 0.5; }),
            "joint j1 from 0.500000 to 0.500000: both must be finite, lower < upper");
  EXPECT_EQ(with([](P& p) {
              p.joints[1].origin.orientation = {0, 0, 0, 0};
            }),
            "joint j1.origin.orientation of norm 0.000000: must be a quaternion other than zero");
  EXPECT_EQ(with([](P& p) { p.joints[1].origin.position.y = NAN; }),
            "joint j1.origin.position: must be finite");
  EXPECT_EQ(with([](P& p) { p.outputs[1].link = "thumb"; }),
            "output b.link = thumb: must be \"base\" or a joint given before");
  EXPECT_EQ(with([](P& p) { p.outputs[1].name = "a"; }), "output a given twice: names must differ");
  EXPECT_EQ(with([](P& p) { p.palm.reset(); }), "output wrist.link = base: nothing moves it");
  EXPECT_NE(with([](P& p) { p.outputs.clear(); }), "accepted");
  EXPECT_NE(with([](P& p) { p.outputs.resize(12); }), "accepted");
  EXPECT_NE(with([](P& p) { p.joints.clear(); }), "accepted");
  EXPECT_NE(with([](P& p) { p.palm->position_upper = -2.0; }), "accepted");
  EXPECT_NE(with([](P& p) {
              for (ChainJoint& joint : p.joints) joint.actuated = false;
            }),
            "accepted");
  EXPECT_NE(with([](P& p) {
              for (int i = 0; i < 20; ++i) {
                p.joints.push_back(p.joints[0]);
                p.joints.back().name = "more" + std::to_string(i);
              }
            }),
            "accepted");
}

}  // namespace
}  // namespace haptic::core
