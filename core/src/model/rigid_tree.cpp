#include "rigid_tree.hpp"

#include <utility>

namespace haptic::core {

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Quaterniond pure(const Vector3d& v) noexcept {
  return {0.0, v.x(), v.y(), v.z()};
}

void store(const Quaterniond& q, double scale, double* column) noexcept {
  for (int i = 0; i < 4; ++i) column[i] = scale * q.coeffs()[i];  // x, y, z, w
}

}  // namespace

static_assert(kMaxQ <= 32, "moved_by_ holds one bit per variable");

struct RigidTree::State {
  Quaterniond Q[kMaxQ];  // bodies; never more than variables
  Vector3d p[kMaxQ];
  Vector3d w[kMaxQ], c[kMaxQ], t[kMaxQ];  // variables
};

RigidTree::RigidTree(std::vector<TreeJoint> joints, std::vector<TreeOutput> outputs)
    : joints_(std::move(joints)), outputs_(std::move(outputs)) {
  for (const TreeJoint& joint : joints_) {
    const bool free = joint.motion == TreeJoint::Motion::kFree;
    std::uint32_t mask = joint.parent < 0 ? 0U : moved_by_[static_cast<std::size_t>(joint.parent)];
    first_.push_back(n_y_);
    for (int i = 0; i < (free ? 6 : 1); ++i) mask |= 1U << n_y_++;
    moved_by_.push_back(mask);
  }
  for (const TreeOutput& output : outputs_) n_x_ += output.kind == OutputKind::kFrame ? 7 : 3;
}

std::vector<Coordinate> RigidTree::coordinates() const {
  std::vector<Coordinate> all;
  for (const TreeOutput& output : outputs_) {
    for (const char* axis : {".x", ".y", ".z"}) {
      all.push_back({output.name + axis, Unit::kMetre, CoordinateKind::kLinear});
    }
    if (output.kind != OutputKind::kFrame) continue;
    for (const char* part : {".qx", ".qy", ".qz", ".qw"}) {
      all.push_back({output.name + part, Unit::kRadian, CoordinateKind::kQuaternion});
    }
  }
  return all;
}

void RigidTree::place(const double* y, State& s) const noexcept {
  for (std::size_t b = 0; b < joints_.size(); ++b) {
    const TreeJoint& joint = joints_[b];
    const int k = first_[b];
    Quaterniond Q = joint.orientation;
    Vector3d p = joint.position;
    if (joint.parent >= 0) {
      Q = s.Q[joint.parent] * Q;
      p = s.p[joint.parent] + s.Q[joint.parent] * p;
    }
    const Vector3d axis = Q * joint.axis;
    switch (joint.motion) {
      case TreeJoint::Motion::kRevolute:
        s.w[k] = axis;
        s.t[k].setZero();
        Q = Q * Quaterniond(Eigen::AngleAxisd(y[k], joint.axis));
        break;
      case TreeJoint::Motion::kPrismatic:
        s.w[k].setZero();
        s.t[k] = axis;
        p += y[k] * axis;
        break;
      case TreeJoint::Motion::kFree: {
        const Vector3d phi(y[k + 3], y[k + 4], y[k + 5]);
        p += Q * Vector3d(y[k], y[k + 1], y[k + 2]);
        const Eigen::Matrix3d J_l = left_jacobian(phi);
        for (int i = 0; i < 3; ++i) {
          s.w[k + i].setZero();
          s.t[k + i] = Q * Vector3d::Unit(i);
          s.c[k + i] = p;
          s.w[k + 3 + i] = Q * J_l.col(i);
          s.t[k + 3 + i].setZero();
          s.c[k + 3 + i] = p;
        }
        Q = Q * exponential(phi);
        break;
      }
    }
    if (joint.motion != TreeJoint::Motion::kFree) s.c[k] = p;
    s.Q[b] = Q.normalized();
    s.p[b] = p;
  }
}

void RigidTree::evaluate(const double* y, VecX& x, MatXQ& J) const noexcept {
  State s;
  place(y, s);
  x.resize(n_x_);
  J.setZero(n_x_, n_y_);
  int row = 0;
  for (const TreeOutput& output : outputs_) {
    const Vector3d p = s.p[output.body] + s.Q[output.body] * output.position;
    const Quaterniond Q = s.Q[output.body] * output.orientation;
    const bool frame = output.kind == OutputKind::kFrame;
    x.segment<3>(row) = p;
    if (frame) x.segment<4>(row + 3) = Q.coeffs();
    for (int k = 0; k < n_y_; ++k) {
      if ((moved_by_[static_cast<std::size_t>(output.body)] >> k & 1U) == 0) continue;
      J.block<3, 1>(row, k) = s.t[k] + s.w[k].cross(p - s.c[k]);
      if (frame) store(pure(s.w[k]) * Q, 0.5, &J(row + 3, k));
    }
    row += frame ? 7 : 3;
  }
}

}  // namespace haptic::core
