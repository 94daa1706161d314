#include "hw/simulated/reach_edge.hpp"

#include <gtest/gtest.h>

namespace haptic::hw {
namespace {

using V = Eigen::Vector2d;

TEST(ReachEdge, APointSlidesAlongOnePlane) {
  ReachEdge edge;
  edge.add({0.01, 0.0}, {0.0, 0.0});  // reach: x <= 0
  EXPECT_TRUE(edge.known());
  EXPECT_LT((edge.nearest({0.02, 0.03}) - V(0.0, 0.03)).norm(), 1e-15);
  EXPECT_EQ(edge.nearest({-0.02, 0.03}), V(-0.02, 0.03));
}

TEST(ReachEdge, TwoPlanesMakeACorner) {
  ReachEdge edge;
  edge.add({0.01, 0.0}, {0.0, 0.0});
  edge.add({0.0, 0.01}, {0.0, 0.0});
  EXPECT_LT(edge.nearest({0.02, 0.03}).norm(), 1e-15);
  EXPECT_LT((edge.nearest({0.02, -0.03}) - V(0.0, -0.03)).norm(), 1e-15);
  EXPECT_LT((edge.nearest({-0.02, 0.03}) - V(-0.02, 0.0)).norm(), 1e-15);
}

TEST(ReachEdge, ForgetsPlanesThatTouchFarAway) {
  ReachEdge edge;
  edge.add({0.01, 0.0}, {0.0, 0.0});
  edge.add({0.0, 1.01}, {0.0, 1.0});
  EXPECT_EQ(edge.nearest({0.5, 0.5}), V(0.5, 0.5));
}

TEST(ReachEdge, SmoothEdgesAreSearchedOften) {
  // Reach: the unit disc. Searches around it keep the nearest point on the circle.
  ReachEdge edge;
  for (double angle = 0.0; angle < 1.0; angle += 0.005) {
    const V direction(std::cos(angle), std::sin(angle));
    edge.add(1.02 * direction, direction);
    const V x = 1.02 * V(std::cos(angle + 0.003), std::sin(angle + 0.003));
    EXPECT_NEAR(edge.nearest(x).norm(), 1.0, 2e-5);
  }
}

TEST(ReachEdge, WithoutPlanesEveryPointIsWithin) {
  ReachEdge edge;
  EXPECT_FALSE(edge.known());
  EXPECT_EQ(edge.nearest({3.0, 4.0}), V(3.0, 4.0));
  edge.add({0.01, 0.0}, {0.0, 0.0});
  edge.clear();
  EXPECT_FALSE(edge.known());
  edge.add({1.0, 1.0}, {1.0, 1.0});  // no depth, no direction: nothing is learnt
  EXPECT_FALSE(edge.known());
}

}  // namespace
}  // namespace haptic::hw
