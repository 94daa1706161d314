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
  for (std::size_t b = 0; b < joints_.size(); ++b) {
    const TreeJoint& joint = joints_[b];
    const bool free = joint.motion == TreeJoint::Motion::kFree;
    std::uint32_t mask = joint.parent < 0 ? 0U : moved_by_[static_cast<std::size_t>(joint.parent)];
    first_.push_back(n_y_);
    for (int i = 0; i < (free ? 6 : 1); ++i) {
      rotation_of_[n_y_] = free && i >= 3 ? static_cast<int>(b) : -1;
      mask |= 1U << n_y_++;
    }
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

bool RigidTree::same_rotation(int i, int k) const noexcept {
  return rotation_of_[i] >= 0 && rotation_of_[i] == rotation_of_[k];
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

void RigidTree::second_order(const double* y, int k, MatXQ& J_k) const noexcept {
  State s;
  place(y, s);
  J_k.setZero(n_x_, n_y_);
  RotationDerivative rotation;
  Quaterniond before = Quaterniond::Identity();  // the rotating joint's frame before it rotates
  if (rotation_of_[k] >= 0) {
    const auto b = static_cast<std::size_t>(rotation_of_[k]);
    const double* phi = y + first_[b] + 3;
    rotation = rotation_derivative(Vector3d(phi[0], phi[1], phi[2]));
    before = joints_[b].orientation;
    if (joints_[b].parent >= 0) before = s.Q[joints_[b].parent] * before;
  }
  int row = 0;
  for (const TreeOutput& output : outputs_) {
    const std::uint32_t mask = moved_by_[static_cast<std::size_t>(output.body)];
    const Vector3d p = s.p[output.body] + s.Q[output.body] * output.position;
    const Quaterniond Q = s.Q[output.body] * output.orientation;
    const bool frame = output.kind == OutputKind::kFrame;
    for (int i = 0; i < n_y_ && (mask >> k & 1U) != 0; ++i) {
      if ((mask >> i & 1U) == 0) continue;
      if (same_rotation(i, k)) {
        // d/dphi_k of w_i x r and 1/2 w_i Q: w_i changes, and r and Q turn with w_k.
        const int first = first_[static_cast<std::size_t>(rotation_of_[k])] + 3;
        const Vector3d dw = before * rotation.dJ_l[k - first].col(i - first);
        const Vector3d r = p - s.c[k];
        J_k.block<3, 1>(row, i) = dw.cross(r) + s.w[i].cross(s.w[k].cross(r));
        if (frame) {
          double turned[4];
          store(pure(dw) * Q, 0.5, &J_k(row + 3, i));
          store(pure(s.w[i]) * (pure(s.w[k]) * Q), 0.25, turned);
          for (int j = 0; j < 4; ++j) J_k(row + 3 + j, i) += turned[j];
        }
        continue;
      }
      const int lo = i < k ? i : k, hi = i < k ? k : i;
      J_k.block<3, 1>(row, i) = s.w[lo].cross(s.t[hi] + s.w[hi].cross(p - s.c[hi]));
      if (frame) store(pure(s.w[lo]) * (pure(s.w[hi]) * Q), 0.25, &J_k(row + 3, i));
    }
    row += frame ? 7 : 3;
  }
}

}  // namespace haptic::core
