#include "haptic/core/model/serial_chain.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptic/core/error.hpp"
#include "rotation.hpp"
#include "tree_map.hpp"

namespace haptic::core {

namespace {

/// Builds the tree joint by joint; body i of the tree is bodies_[i].
class ChainBuilder {
 public:
  explicit ChainBuilder(const std::optional<TrackedPalm>& palm) {
    if (!palm) return;
    append_palm(*palm, dofs_);
    base_ = 0;
    bodies_.emplace_back("base");
    joints_.push_back({TreeJoint::Motion::kFree});
  }

  void add(const ChainJoint& joint) {
    require_new_name(joint.name, dofs_);
    const std::string where = "joint " + joint.name;
    require_pose(joint.origin, where + ".origin");
    const Eigen::Vector3d axis = vector(joint.axis);
    if (!(std::isfinite(axis.norm()) && axis.norm() > 1e-9)) {
      throw SceneError(where + ".axis of length " + std::to_string(axis.norm()) +
                       ": must be finite and not zero");
    }
    if (!(std::isfinite(joint.lower) && std::isfinite(joint.upper) && joint.lower < joint.upper)) {
      throw SceneError(where + " from " + std::to_string(joint.lower) + " to " +
                       std::to_string(joint.upper) + ": both must be finite, lower < upper");
    }
    const bool revolute = joint.kind == JointKind::kRevolute;
    const int parent = joint.parent.empty() ? last_body() : body(joint.parent, where + ".parent");
    joints_.push_back({revolute ? TreeJoint::Motion::kRevolute : TreeJoint::Motion::kPrismatic,
                       parent, quaternion(joint.origin.orientation), vector(joint.origin.position),
                       axis.normalized()});
    bodies_.push_back(joint.name);
    dofs_.push_back({joint.name, revolute ? Unit::kRadian : Unit::kMetre, joint.actuated,
                     joint.lower, joint.upper});
  }

  void add(const ChainOutput& output) {
    const std::string where = "output " + output.name;
    require_new_output(output.name, output.offset, outputs_);
    const int on = output.link.empty() ? last_body() : body(output.link, where + ".link");
    if (on < 0) throw SceneError(where + ".link = base: nothing moves it");
    outputs_.push_back({output.name, on, output.kind, vector(output.offset.position),
                        quaternion(output.offset.orientation)});
  }

  std::unique_ptr<Kinematics> finish() && {
    const int rotation = base_ == 0 ? 3 : -1;
    return std::make_unique<TreeMap>(RigidTree(std::move(joints_), std::move(outputs_)),
                                     std::move(dofs_), std::vector<TreeDrive>{}, rotation);
  }

 private:
  [[nodiscard]] int last_body() const { return static_cast<int>(bodies_.size()) - 1; }

  [[nodiscard]] int body(const std::string& name, const std::string& where) const {
    if (name == "base") return base_;
    const auto at = std::find(bodies_.begin(), bodies_.end(), name);
    if (at == bodies_.end()) {
      throw SceneError(where + " = " + name + ": must be \"base\" or a joint given before");
    }
    return static_cast<int>(at - bodies_.begin());
  }

  int base_{-1};
  std::vector<std::string> bodies_{};
  std::vector<TreeJoint> joints_{};
  std::vector<TreeOutput> outputs_{};
  std::vector<DofSpec> dofs_{};
};

}  // namespace

std::unique_ptr<Kinematics> make_serial_chain(const SerialChainParameters& parameters) {
  const std::size_t n_q = parameters.joints.size() + (parameters.palm ? 6U : 0U);
  if (parameters.joints.empty() || n_q > static_cast<std::size_t>(kMaxQ)) {
    throw SceneError("serial chain with " + std::to_string(n_q) +
                     " DoFs: must have at least one joint and at most " + std::to_string(kMaxQ) +
                     " DoFs");
  }
  ChainBuilder builder(parameters.palm);
  for (const ChainJoint& joint : parameters.joints) builder.add(joint);
  for (const ChainOutput& output : parameters.outputs) builder.add(output);
  return std::move(builder).finish();
}

}  // namespace haptic::core
