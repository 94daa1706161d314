#include "server/owner/state/drawing_message.hpp"

namespace haptic::server {
namespace {

using Doubles = google::protobuf::RepeatedField<double>;
using Kind = core::DrawnMotion::Kind;

template <typename Vector>
void add(const Vector& from, Doubles* to) {
  to->Add(from.data(), from.data() + from.size());
}

/// Left out if it is zero, as the schema allows.
void add_point(const Eigen::Vector3d& from, Doubles* to) {
  if (!from.isZero(0.0)) add(from, to);
}

void to_message(const core::DrawnMotion& motion, v1::DrawnMotion& message) {
  message.set_kind(static_cast<v1::DrawnMotion::Kind>(motion.kind));
  message.set_offset(motion.offset);
  if (motion.kind == Kind::kAim) {
    message.set_target(static_cast<std::uint32_t>(motion.target));
    add_point(motion.target_point, message.mutable_target_point());
    return;
  }
  message.set_value(static_cast<v1::DrawnValue>(motion.value));
  message.set_index(static_cast<std::uint32_t>(motion.index));
  if (motion.kind != Kind::kRotation && motion.kind != Kind::kTranslation) return;
  message.set_factor(motion.factor);
  add(motion.axis, message.mutable_axis());
}

void to_message(const core::DrawnBody& body, v1::DrawnBody& message) {
  message.set_name(body.name);
  message.set_part(static_cast<v1::DrawnPart>(body.part));
  message.set_parent(body.parent);
  add_point(body.position, message.mutable_position());
  if (!body.orientation.isApprox(Eigen::Quaterniond::Identity(), 0.0)) {
    add(body.orientation.coeffs(), message.mutable_orientation());
  }
  for (const core::DrawnMotion& motion : body.motions) to_message(motion, *message.add_motions());
  for (const core::DrawnCapsule& capsule : body.capsules) {
    v1::DrawnCapsule& shape = *message.add_capsules();
    add_point(capsule.from, shape.mutable_from());
    add_point(capsule.to, shape.mutable_to());
    shape.set_radius(capsule.radius);
  }
}

}  // namespace

v1::Drawing to_message(const core::Drawing& drawing) {
  v1::Drawing message;
  for (const core::DrawnBody& body : drawing.bodies) to_message(body, *message.add_bodies());
  for (const core::DrawnForce& force : drawing.forces) {
    v1::DrawnForce& entry = *message.add_forces();
    entry.set_actuator(static_cast<std::uint32_t>(force.actuator));
    entry.set_body(static_cast<std::uint32_t>(force.body));
    add_point(force.point, entry.mutable_point());
    add(force.axis, entry.mutable_axis());
    entry.set_torque(force.torque);
  }
  return message;
}

}  // namespace haptic::server
