#pragma once
/// A tree of rigid bodies in variables y, and the points and frames on them: x and J = dx/dy,
/// exact. The engine behind serial chains and the tracked hand.
///
/// Each variable k moves its bodies with an angular velocity w_k about the point c_k and a linear
/// velocity t_k: a point p on them has dp/dy_k = t_k + w_k x (p - c_k), a frame's quaternion Q has
/// dQ/dy_k = 1/2 w_k Q. Variables are numbered parents first.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "haptic/core/model/configuration_space.hpp"
#include "haptic/core/model/rigid_pose.hpp"
#include "rotation.hpp"

namespace haptic::core {

struct TreeJoint {
  enum class Motion : std::uint8_t { kRevolute, kPrismatic, kFree };
  Motion motion{Motion::kRevolute};
  int parent{-1};  ///< body, or -1 for the world
  Eigen::Quaterniond orientation{Eigen::Quaterniond::Identity()};
  Eigen::Vector3d position{Eigen::Vector3d::Zero()};
  Eigen::Vector3d axis{Eigen::Vector3d::UnitZ()};  ///< unit
};

struct TreeOutput {
  std::string name{};
  int body{0};
  OutputKind kind{OutputKind::kPoint};
  Eigen::Vector3d position{Eigen::Vector3d::Zero()};
  Eigen::Quaterniond orientation{Eigen::Quaterniond::Identity()};
};

class RigidTree {
 public:
  /// Body b is what joint b moves. A free joint has six variables (position, rotation vector), the
  /// others one. At most kMaxQ variables and kMaxX coordinates: checked by the caller.
  RigidTree(std::vector<TreeJoint> joints, std::vector<TreeOutput> outputs);

  [[nodiscard]] int n_x() const noexcept { return n_x_; }
  [[nodiscard]] std::vector<Coordinate> coordinates() const;
  [[nodiscard]] const std::vector<TreeJoint>& joints() const noexcept { return joints_; }
  [[nodiscard]] const std::vector<TreeOutput>& outputs() const noexcept { return outputs_; }
  /// True where variable k moves output `o`.
  [[nodiscard]] bool moves(int k, std::size_t o) const noexcept {
    return (moved_by_[static_cast<std::size_t>(outputs_[o].body)] >> k & 1U) != 0;
  }

  /// x: n_x. J: n_x by n_y. y: n_y, finite.
  void evaluate(const double* y, VecX& x, MatXQ& J) const noexcept;

 private:
  struct State;  // bodies and twists at one y
  void place(const double* y, State& s) const noexcept;

  std::vector<TreeJoint> joints_;
  std::vector<TreeOutput> outputs_;
  std::vector<int> first_;               ///< first variable of each joint
  std::vector<std::uint32_t> moved_by_;  ///< per body: bit k set where variable k moves it
  int n_y_{0};
  int n_x_{0};
};

}  // namespace haptic::core
