/// A rigid tree as bodies: every joint moves a body of the device by its own DoF, every output is a
/// body of the tool. In place of the two joints of a driven finger stands the drawing of its
/// mechanism, which finds them by itself.
#include <algorithm>

#include "drawing_parts.hpp"
#include "tree_map.hpp"

namespace haptic::core {

namespace {

using Eigen::Vector3d;

constexpr double kJoint = 1.5, kOutput = 1.8;  // radii, of a link's

double radius_of(const std::vector<TreeJoint>& joints, const std::vector<TreeOutput>& outputs) {
  double longest = 0.0;
  for (const TreeJoint& joint : joints) longest = std::max(longest, joint.position.norm());
  for (const TreeOutput& output : outputs) longest = std::max(longest, output.position.norm());
  return link_radius(longest);
}

/// A line from the body's origin, unless the point is the origin.
void append_line(const Vector3d& to, double radius, DrawnBody& body) {
  if (to.norm() > radius) body.capsules.push_back({Vector3d::Zero(), to, radius});
}

DrawnBody tool_body(const TreeOutput& output, int first_x, double radius) {
  DrawnBody body{.name = output.name, .part = DrawnPart::kTool, .motions = place_by_x(first_x)};
  Vector3d joint = Vector3d::Zero();  // of the body it is on, as seen from the output
  if (output.kind == OutputKind::kFrame) {
    body.motions.push_back(
        {.kind = DrawnMotion::Kind::kOrientation, .value = DrawnValue::kX, .index = first_x + 3});
    joint = output.orientation.conjugate() * -output.position;
  }
  body.capsules.push_back({Vector3d::Zero(), joint, kOutput * radius});
  return body;
}

class TreeDrawing {
 public:
  TreeDrawing(const RigidTree& tree, const std::vector<DofSpec>& dofs)
      : dofs_(dofs), radius_(radius_of(tree.joints(), tree.outputs())) {
    const bool fixed = tree.joints().front().motion != TreeJoint::Motion::kFree;
    if (fixed) drawing_.bodies.push_back({.name = "base"});
  }

  void add_palm() {
    DrawnBody body{.name = name_before_dot(k_)};
    for (int i = 0; i < 3; ++i) body.motions.push_back(slide_by_q(Vector3d::Unit(i), k_ + i));
    body.motions.push_back({.kind = DrawnMotion::Kind::kRotationVector, .index = k_ + 3});
    k_ += 6;
    add(std::move(body));
  }

  void add_joint(const TreeJoint& joint) {
    const DofSpec& dof = dofs_[static_cast<std::size_t>(k_)];
    const bool turns = joint.motion == TreeJoint::Motion::kRevolute;
    DrawnBody body{.name = dof.name,
                   .parent = body_of(joint.parent),
                   .position = joint.position,
                   .orientation = joint.orientation,
                   .motions = {turns ? turn_by_q(joint.axis, k_) : slide_by_q(joint.axis, k_)}};
    const Vector3d half = kJoint * radius_ * joint.axis;
    body.capsules.push_back({-half, half, kJoint * radius_});
    append_line(joint.position, radius_, drawn(joint.parent));
    if (!turns) {  // its rail
      const Vector3d along = joint.orientation * joint.axis;
      drawn(joint.parent)
          .capsules.push_back(
              {joint.position + dof.lower * along, joint.position + dof.upper * along, radius_});
    }
    if (dof.actuated) {
      const int moved = static_cast<int>(drawing_.bodies.size());
      drawing_.forces.push_back(
          {.actuator = a_++, .body = moved, .axis = joint.axis, .torque = turns});
    }
    ++k_;
    add(std::move(body));
  }

  /// In place of the two joints that it turns; `first` is the upper one.
  void add_mechanism(const Kinematics& mechanism, const TreeJoint& first) {
    append_line(first.position, radius_, drawn(first.parent));
    append(mechanism.drawing(),
           {.prefix = name_before_dot(k_) + ".",
            .parent = body_of(first.parent),
            .position = first.position,
            .orientation = first.orientation,
            .first_q = k_,
            .first_a = a_,
            .with_tool = false},
           drawing_);
    k_ += mechanism.layout().n_q();
    a_ += mechanism.layout().n_a();
    bodies_.insert(bodies_.end(), 2, kOfMechanism);
  }

  void add_output(const TreeOutput& output) {
    if (body_of(output.body) != kOfMechanism) {
      append_line(output.position, radius_, drawn(output.body));
    }
    drawing_.bodies.push_back(tool_body(output, first_x_, radius_));
    first_x_ += output.kind == OutputKind::kFrame ? 7 : 3;
  }

  /// The DoF that the next joint has.
  [[nodiscard]] int next_dof() const noexcept { return k_; }
  [[nodiscard]] Drawing finish() && { return std::move(drawing_); }

 private:
  static constexpr int kOfMechanism = -1;

  void add(DrawnBody body) {
    bodies_.push_back(static_cast<int>(drawing_.bodies.size()));
    drawing_.bodies.push_back(std::move(body));
  }
  /// "index" of "index.l_x".
  [[nodiscard]] std::string name_before_dot(int k) const {
    const std::string& name = dofs_[static_cast<std::size_t>(k)].name;
    return name.substr(0, name.find('.'));
  }
  [[nodiscard]] int body_of(int joint) const {
    return joint < 0 ? 0 : bodies_[static_cast<std::size_t>(joint)];
  }
  [[nodiscard]] DrawnBody& drawn(int joint) {
    return drawing_.bodies[static_cast<std::size_t>(body_of(joint))];
  }

  const std::vector<DofSpec>& dofs_;
  double radius_;
  Drawing drawing_{};
  std::vector<int> bodies_{};  ///< per joint
  int k_{0}, a_{0}, first_x_{0};
};

}  // namespace

Drawing TreeMap::drawing() const {
  TreeDrawing drawing(tree_, dofs_);
  for (std::size_t b = 0; b < tree_.joints().size(); ++b) {
    const TreeJoint& joint = tree_.joints()[b];
    const auto drive = std::find_if(
        drives_.begin(), drives_.end(),
        [&](const TreeDrive& candidate) { return candidate.first == drawing.next_dof(); });
    if (drive != drives_.end()) {
      drawing.add_mechanism(*drive->mechanism, joint);
      ++b;
    } else if (joint.motion == TreeJoint::Motion::kFree) {
      drawing.add_palm();
    } else {
      drawing.add_joint(joint);
    }
  }
  for (const TreeOutput& output : tree_.outputs()) drawing.add_output(output);
  return std::move(drawing).finish();
}

}  // namespace haptic::core
