// Contacts that name few coordinates of many.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "haptic/core/contacts/plane_projection.hpp"

namespace haptic::core {
namespace {

constexpr int kMany = 40, kFirst = 17;  // of which three are named from there on

/// Two soft curved contacts on one object, in the three coordinates from `first` on of n_x.
PlaneSet contacts(int n_x, int first) {
  PlaneSet set;
  set.normals.setZero(n_x, 2);
  set.normals.col(0).segment<2>(first) << 1.0, 0.5;  // its curvature names another coordinate
  set.normals.col(1).segment<2>(first + 1) << 0.8, -1.0;
  set.offsets.setConstant(2, 0.01);
  set.compliance.setConstant(2, 0.5);
  set.velocity.setZero(2);
  set.laws.resize(4, 2);
  set.laws.colwise() = Eigen::Vector4d(1e-3, 0.01, 0.5, -0.002);
  set.objects.setZero(Eigen::NoChange, 2);
  set.objects.row(0).setOnes();
  set.objects(1, 0) = set.objects(1, 1) = 1.0;
  set.curvature.resize(6);
  set.curvature << 4.0, 1.0, 3.0, 5.0, -1.0, 2.0;
  set.curved[0] = set.curved[1] = 2;
  set.first[0] = static_cast<std::uint8_t>(first + 1);
  set.first[1] = static_cast<std::uint8_t>(first);
  return set;
}

/// 30 ticks behind an anchored sample.
std::vector<VecX> run(int n_x, int first, const TaskMetric& metric) {
  const ConfigurationSpace space(std::vector<Coordinate>(static_cast<std::size_t>(n_x)));
  PlaneProjection projection(space, metric);
  VecX at = VecX::Zero(n_x), used = VecX::Zero(n_x);
  used.segment<3>(first) << 0.02, 0.01, -0.01;
  at.segment<3>(first) << 0.015, 0.008, -0.005;
  projection.set(contacts(n_x, first), at, &used);
  std::vector<VecX> way;
  for (int k = 0; k < 30; ++k) {
    VecX probe = used, x;
    probe[first] += 1e-3 * k;
    static_cast<void>(projection.project(probe, x, 0.0, 1e-3));
    way.push_back(x);
  }
  return way;
}

/// W on the three coordinates, and 1 on the others.
TaskMetric metric_of(int n_x, int first, double mixed) {
  Eigen::MatrixXd W = Eigen::MatrixXd::Identity(n_x, n_x);
  W.block<3, 3>(first, first) << 2.0, mixed, 0.0, mixed, 3.0, mixed, 0.0, mixed, 1.5;
  return TaskMetric::from_matrix(W);
}

TEST(ContactGaps, FewOfManyCoordinatesAreAlike) {
  for (const double mixed : {-1.0, 0.0, 0.4}) {
    SCOPED_TRACE(mixed);
    const TaskMetric few = mixed < 0.0 ? TaskMetric() : metric_of(3, 0, mixed);
    const TaskMetric many = mixed < 0.0 ? TaskMetric() : metric_of(kMany, kFirst, mixed);
    const std::vector<VecX> alone = run(3, 0, few), among = run(kMany, kFirst, many);
    double moved = 0.0;
    for (std::size_t k = 0; k < alone.size(); ++k) {
      EXPECT_NEAR((among[k].segment<3>(kFirst) - alone[k]).norm(), 0.0, 1e-12) << k;
      EXPECT_NEAR(among[k].norm(), alone[k].norm(), 1e-12) << "the others stay";
      moved = std::max(moved, (alone[k] - alone[0]).norm());
    }
    EXPECT_GT(moved, 1e-3);
  }
}

}  // namespace
}  // namespace haptic::core
