#pragma once
/// A rigid tree as a device's map: q itself drives the tree, except where a mechanism (a finger
/// exoskeleton) stands between its DoFs and the joints they turn.

#include <memory>
#include <vector>

#include "haptic/core/model/drawing.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "rigid_tree.hpp"

namespace haptic::core {

/// y[first, first + 2) = f(q[first, first + 2)): two DoFs drive two joints.
struct TreeDrive {
  int first{0};
  std::shared_ptr<const Kinematics> mechanism{};
};

class TreeMap final : public Kinematics {
 public:
  /// `dofs`: one per variable of the tree. `rotation`: index of the palm's rotation vector in q, or
  /// -1. Throws SceneError: no or too many DoFs, none actuated, too many coordinates.
  TreeMap(RigidTree tree, std::vector<DofSpec> dofs, std::vector<TreeDrive> drives, int rotation);

  MapStatus evaluate(const VecQ& q, VecX& x_probe, MatXQ& J) const noexcept override;
  void nearest_representative(const VecQ& near, VecQ& q) const noexcept override;
  std::span<const Mechanism> mechanisms() const noexcept override { return mechanisms_; }
  Drawing drawing() const override;

 private:
  struct Joints;  // y and dy/dq at one q
  /// False where q is not finite or a mechanism cannot close.
  [[nodiscard]] bool joints_of(const VecQ& q, Joints& joints) const noexcept;
  /// J_q = J_y dy/dq, in place.
  void through_mechanisms(const Joints& joints, MatXQ& J) const noexcept;

  RigidTree tree_;
  std::vector<TreeDrive> drives_;
  std::vector<Mechanism> mechanisms_{};  ///< of the drives
  int rotation_;
};

/// Six specs of a tracked palm: position, rotation vector; sensed, unactuated.
void append_palm(const TrackedPalm& palm, std::vector<DofSpec>& dofs);
/// Throws SceneError unless the name is given and new among the specs.
void require_new_name(const std::string& name, const std::vector<DofSpec>& dofs);
/// Throws SceneError unless the output's name is given and new, and its offset is a pose.
void require_new_output(const std::string& name, const Pose3& offset,
                        const std::vector<TreeOutput>& others);
/// Throws SceneError naming `where` unless finite (and, for quaternions, not zero).
void require_pose(const Pose3& pose, const std::string& where);

}  // namespace haptic::core
