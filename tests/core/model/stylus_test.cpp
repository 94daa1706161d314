#include "haptic/core/model/stylus.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/support/dense_oracle.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::core {
namespace {

TEST(Stylus, SensesSixDofsAndDrivesThree) {
  const auto stylus = make_stylus({});
  EXPECT_EQ(stylus->layout().n_q(), 6);
  ASSERT_EQ(stylus->layout().n_a(), 3);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(stylus->layout().actuated(i), i);
  EXPECT_EQ(stylus->space().n_x(), 7);
  EXPECT_TRUE(stylus->space().mixes_units()) << "a frame needs a metric";
  EXPECT_FALSE(make_stylus({}, marks_on_a_stylus())->space().mixes_units());
}

/// Trigonometry in the vertical plane that the turntable turns.
TEST(Stylus, PoseFollowsTrigonometry) {
  const StylusDimensions d;
  const auto stylus = make_stylus(d);
  const double turn = 0.4, shoulder = 0.9, elbow = -1.3, pitch = 0.25, roll = 0.7;
  VecX x;
  const VecQ q = (VecQ(6) << turn, shoulder, elbow, 0, pitch, roll).finished();
  ASSERT_EQ(stylus->position(q, x), MapStatus::kOk);
  const double forearm = shoulder + elbow, along = forearm + pitch;
  const double radius =
      d.upper_arm * std::cos(shoulder) + d.forearm * std::cos(forearm) + d.tip * std::cos(along);
  const double height =
      d.upper_arm * std::sin(shoulder) + d.forearm * std::sin(forearm) + d.tip * std::sin(along);
  EXPECT_NEAR(x[0], radius * std::cos(turn), 1e-15);
  EXPECT_NEAR(x[1], radius * std::sin(turn), 1e-15);
  EXPECT_NEAR(x[2], height, 1e-15);
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(-along, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  const Eigen::Quaterniond Q(x[6], x[3], x[4], x[5]);
  EXPECT_LT((Q.toRotationMatrix() - R).cwiseAbs().maxCoeff(), 1e-15);
}

/// The gimbal cannot be pushed, but it must not lock: full column rank all over the box.
TEST(Stylus, IsNowhereSingularInItsBox) {
  const auto stylus = make_stylus({});
  double worst = 0.0;
  VecX x;
  MatXQ J;
  for (int s = 0; s < 2000; ++s) {
    ASSERT_EQ(stylus->evaluate(workspace_sample(*stylus, s), x, J), MapStatus::kOk);
    Eigen::MatrixXd scaled = J;  // lengths by 0.1 m: both units alike
    scaled.topRows(3) /= 0.1;
    worst = std::max(worst, oracle::condition(scaled));
  }
  EXPECT_LT(worst, 40.0);
  RecordProperty("worst_condition", std::to_string(worst));
}

TEST(Stylus, SaysWhichLengthCannotBe) {
  StylusDimensions d;
  d.forearm = 0.0;
  EXPECT_EQ(haptic::test::message_of<SceneError>([&] { return make_stylus(d); }),
            "stylus.forearm_m = 0.000000: must be finite and > 0");
  d = {};
  d.elbow_upper = d.elbow_lower;
  EXPECT_THROW(static_cast<void>(make_stylus(d)), SceneError);
}

}  // namespace
}  // namespace haptic::core
