#include "tests/report/analysis/linkage_quality.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/src/model/finger_linkage.hpp"
#include "tests/support/percentile.hpp"

namespace haptic::core {

namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr double kStrong = 0.005;       // m/rad
constexpr double kStiffness = 1500.0;   // N/m, of the scenes
constexpr double kUnitOfTravel = 0.02;  // m, core/METHOD.md#finger-linkage

double condition(const LinkagePose& p) {
  const double a = p.J(0, 0) * kUnitOfTravel, b = p.J(0, 1);
  const double c = p.J(1, 0) * kUnitOfTravel, d = p.J(1, 1);
  const double sum = a * a + b * b + c * c + d * d, det = a * d - b * c;
  const double root = std::sqrt(std::max(0.0, sum * sum - 4.0 * det * det));
  return std::sqrt((sum + root) / std::max(sum - root, 1e-300));
}

bool within(double value, double lower, double upper) {
  return value >= lower && value <= upper;
}

std::optional<LinkageNode> node_of(const FingerLinkage& linkage, double mcp, double pip) {
  const FingerDimensions& d = linkage.dimensions();
  ClosedPose closed;
  LinkagePose pose;
  if (!linkage.closed_inverse(mcp, pip, closed) || !within(closed.l, d.l_x_lower, d.l_x_upper) ||
      !within(closed.t, d.q_B_lower, d.q_B_upper) ||
      !within(closed.c1, d.slider1_lower, d.slider1_upper) ||
      !within(closed.c2, d.slider2_lower, d.slider2_upper) ||
      !linkage.pose(closed.l, closed.t, pose)) {
    return {};
  }
  const double det = pose.det();
  return LinkageNode{.l = closed.l,
                     .c1 = closed.c1,
                     .c2 = closed.c2,
                     .w1 = pose.J(1, 1) / det,
                     .w2 = -pose.J(0, 1) / det,
                     .condition = condition(pose),
                     .pivot_height = d.rail_origin.y + closed.l * std::sin(d.rail_angle)};
}

}  // namespace

void Range::add(double value) {
  lowest = std::min(lowest, value);
  highest = std::max(highest, value);
}

std::optional<LinkageNode> linkage_node(const FingerDimensions& dimensions, double mcp,
                                        double pip) {
  return node_of(FingerLinkage(dimensions), mcp, pip);
}

LinkageQuality linkage_quality(const FingerDimensions& dimensions, double step) {
  const FingerLinkage linkage(dimensions);
  LinkageQuality q;
  int all = 0, all_reached = 0, workspace = 0, reached = 0, positive = 0, strong = 0;
  std::vector<double> conditions, felt_mcp, felt_pip;
  Range travel;
  const int first = -static_cast<int>(15.0 / step), last = static_cast<int>(80.0 / step);
  for (int i = first; i <= last; ++i) {
    const double highest_pip = i < 0 ? 70.0 : 90.0;
    for (int j = 0; j * step <= highest_pip; ++j) {
      const auto node = node_of(linkage, i * step * kDegree, j * step * kDegree);
      ++all;
      if (i >= 0) ++workspace;
      if (!node) continue;
      ++all_reached;
      travel.add(node->l);
      if (i < 0) continue;
      ++reached;
      positive += node->w1 > 0.0 && node->w2 > 0.0 ? 1 : 0;
      strong += node->w1 >= kStrong && node->w2 >= kStrong ? 1 : 0;
      q.w1.add(node->w1);
      q.w2.add(node->w2);
      q.c1.add(node->c1);
      q.c2.add(node->c2);
      q.condition.add(node->condition);
      q.pivot_height.add(node->pivot_height);
      conditions.push_back(node->condition);
      felt_mcp.push_back(kStiffness * node->w1 * node->w1);
      felt_pip.push_back(kStiffness * node->w2 * node->w2);
    }
  }
  q.reach = static_cast<double>(reached) / workspace;
  q.with_straight = static_cast<double>(all_reached) / all;
  if (reached == 0) return q;
  q.both_positive = static_cast<double>(positive) / reached;
  q.both_strong = static_cast<double>(strong) / reached;
  q.median_condition = test::percentile(conditions, 0.5);
  q.median_felt_mcp = test::percentile(felt_mcp, 0.5);
  q.median_felt_pip = test::percentile(felt_pip, 0.5);
  q.stroke = travel.width();
  return q;
}

}  // namespace haptic::core
