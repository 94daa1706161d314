#include "tests/report/analysis/displayed_impedance.hpp"

#include <Eigen/QR>
#include <cmath>

#include "haptic/core/linear/householder.hpp"

namespace haptic::core {

namespace {

/// Parts of every formula below, at one pose.
struct Pose {
  VecX x_probe{};
  MatXQ J{};
  MatXQ J_a{};
  MatXQ J_n{};
};

struct FullColumnRank {
  MatAX inverse{};  ///< A^+, n by n_x
  MatXX off{};      ///< I - A A^+, the projector onto what A does not reach
};

/// Empty if the rank of A, n_x by n, is below n. Columns are scaled to unit length first, so that
/// no choice of units looks like a lost rank.
std::optional<FullColumnRank> full_column_rank(const MatXQ& A) {
  const Eigen::Index m = A.rows(), n = A.cols();
  FullColumnRank result{MatAX(n, m), MatXX::Identity(m, m)};
  if (n == 0) return result;
  if (m < n) return std::nullopt;
  const VecQ norms = A.colwise().norm().transpose();
  if (!(norms.minCoeff() > 0.0)) return std::nullopt;
  // Offline, so sized freely: the compiler knows these types already.
  const Eigen::MatrixXd scaled = A * norms.cwiseInverse().asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(kRankThreshold);
  if (qr.rank() < n) return std::nullopt;
  const Eigen::MatrixXd pseudo_inverse = qr.solve(Eigen::MatrixXd::Identity(m, m));
  result.inverse = norms.cwiseInverse().asDiagonal() * pseudo_inverse;
  result.off.noalias() -= A * result.inverse;
  return result;
}

MatXQ columns(const MatXQ& J, const DofLayout& layout, bool actuated) {
  const int n = actuated ? layout.n_a() : layout.n_n();
  MatXQ part(J.rows(), n);
  for (int i = 0; i < n; ++i) {
    part.col(i) = J.col(actuated ? layout.actuated(i) : layout.sensed(i));
  }
  return part;
}

std::optional<Pose> pose_at(const Kinematics& kinematics, const VecQ& q) {
  Pose pose;
  if (kinematics.evaluate(q, pose.x_probe, pose.J) != MapStatus::kOk) return std::nullopt;
  pose.J_a = columns(pose.J, kinematics.layout(), true);
  pose.J_n = columns(pose.J, kinematics.layout(), false);
  return pose;
}

/// J_k = dJ/dq_k by central differences of the fourth order: to 1e-11 of J. False where f has no
/// value next to q.
bool derivative_of_J(const Kinematics& kinematics, const VecQ& q, int k, MatXQ& J_k) {
  const DofSpec& dof = kinematics.dofs()[static_cast<std::size_t>(k)];
  const double h = 2e-4 * (dof.upper - dof.lower);
  VecX x;
  MatXQ J[4];
  constexpr double kPlaces[] = {-2.0, -1.0, 1.0, 2.0};
  for (int i = 0; i < 4; ++i) {
    VecQ at = q;
    at[k] += kPlaces[i] * h;
    if (kinematics.evaluate(at, x, J[i]) != MapStatus::kOk) return false;
  }
  J_k = (J[0] - J[3] + 8.0 * (J[2] - J[1])) / (12.0 * h);
  return true;
}

/// -Z_q S: Eq. (9), and the exact impedance of Eq. (6).
MatAQ subspace_impedance(const DofLayout& layout, const MatAA& Z_q) {
  MatAQ result = MatAQ::Zero(layout.n_a(), layout.n_q());
  for (int i = 0; i < layout.n_a(); ++i) result.col(layout.actuated(i)) = -Z_q.col(i);
  return result;
}

/// Z_q S A.
template <typename Matrix>
MatAX actuated_rows(const DofLayout& layout, const MatAA& Z_q, const Matrix& A) {
  MatAX rows(layout.n_a(), A.cols());
  for (int i = 0; i < layout.n_a(); ++i) rows.row(i) = A.row(layout.actuated(i));
  return Z_q * rows;
}

/// Column k of the exact impedance of the standard method: J_a,k^T Z_x dx - J_a^T Z_x J_k.
VecA standard_column(const Pose& pose, const MatXQ& J_a_k, const VecX& f, const MatXX& Z_x, int k) {
  return J_a_k.transpose() * f - pose.J_a.transpose() * (Z_x * pose.J.col(k));
}

/// The same of the null-space method, tau_a = J_a^T N f. The projector turns with J_n:
/// dN = -(N J_n,k J_n^+ + (N J_n,k J_n^+)^T).
VecA null_space_column(const Pose& pose, const FullColumnRank& n, const MatXQ& J_a_k,
                       const MatXQ& J_n_k, const VecX& f, const MatXX& Z_x, int k) {
  const MatXX turn = n.off * J_n_k * n.inverse;
  const VecX N_f = n.off * f;
  const VecX dN_f = -(turn * f + turn.transpose() * f);
  return J_a_k.transpose() * N_f + pose.J_a.transpose() * dN_f -
         pose.J_a.transpose() * (n.off * (Z_x * pose.J.col(k)));
}

/// The same of dq in Eq. (8): d_k(dq) = -e_k - J^+ J_k dq + (J^T J)^{-1} J_k^T r, n_q rows.
VecQ linear_column(const FullColumnRank& j, const MatXQ& J_k, const VecQ& dq, const VecX& r,
                   int k) {
  VecQ column = -(j.inverse * (J_k * dq));
  // (J^T J)^{-1} = J^+ J^{+T}; r is orthogonal to J, which J_k^T r is not.
  column += j.inverse * (j.inverse.transpose() * (J_k.transpose() * r));
  column[k] -= 1.0;
  return column;
}

/// G of core/METHOD.md#exact-derivatives at q_star, n_q by n_x.
std::optional<MatAX> exact_proxy_motion(const Kinematics& kinematics, const VecX& x,
                                        const VecQ& q_star) {
  const std::optional<Pose> pose = pose_at(kinematics, q_star);
  if (!pose) return std::nullopt;
  const int n_q = kinematics.layout().n_q(), n_x = kinematics.space().n_x();
  VecX r(n_x);
  kinematics.space().difference(x, pose->x_probe, r);
  int free[kMaxQ];
  int n = 0;
  for (int i = 0; i < n_q; ++i) {
    const DofSpec& dof = kinematics.dofs()[static_cast<std::size_t>(i)];
    const double slack = 1e-9 * (dof.upper - dof.lower);  // rounding of an iterated q*
    if (q_star[i] > dof.lower + slack && q_star[i] < dof.upper - slack) free[n++] = i;
  }
  MatAX G = MatAX::Zero(n_q, n_x);
  if (n == 0) return G;
  MatXQ J_free(n_x, n);
  for (int i = 0; i < n; ++i) J_free.col(i) = pose->J.col(free[i]);
  MatAQ normal = J_free.transpose() * J_free;
  for (int k = 0; k < n; ++k) {
    MatXQ J_k;
    if (!derivative_of_J(kinematics, q_star, free[k], J_k)) return std::nullopt;
    for (int i = 0; i < n; ++i) normal(i, k) -= J_k.col(free[i]).dot(r);
    // A slope left over means that something else than the box holds q*.
    if (std::abs(J_free.col(k).dot(r)) > 1e-6 * J_free.col(k).norm() * (r.norm() + 1e-6)) {
      return std::nullopt;
    }
  }
  const std::optional<FullColumnRank> inverse = full_column_rank(normal);
  if (!inverse) return std::nullopt;
  const MatAX moved = inverse->inverse * J_free.transpose();
  for (int i = 0; i < n; ++i) G.row(free[i]) = moved.row(i);
  return G;
}

}  // namespace

MatAA RenderingImpedance::actuated() const noexcept {
  return coupling ? coupling->matrix(Z_q) : MatAA(Z_q.asDiagonal());
}

std::optional<MatAQ> theoretical_impedance(RendererKind kind, const Kinematics& kinematics,
                                           const VecQ& q, const RenderingImpedance& impedance) {
  const std::optional<Pose> pose = pose_at(kinematics, q);
  if (!pose) return std::nullopt;
  switch (kind) {
    case RendererKind::kStandard:  // Eq. (2)
      return MatAQ(-pose->J_a.transpose() * impedance.Z_x * pose->J);
    case RendererKind::kNullSpace: {  // Eq. (5)
      const std::optional<FullColumnRank> n = full_column_rank(pose->J_n);
      if (!n) return std::nullopt;
      return MatAQ(-pose->J_a.transpose() * n->off * impedance.Z_x * pose->J);
    }
    case RendererKind::kSubspaceLinear:
    case RendererKind::kSubspaceExact:
    case RendererKind::kPerContact:  // at most that
      break;
  }
  return subspace_impedance(kinematics.layout(), impedance.actuated());  // Eq. (9)
}

std::optional<MatAQ> exact_impedance(RendererKind kind, const Kinematics& kinematics, const VecQ& q,
                                     const VecX& x, const RenderingImpedance& impedance) {
  const DofLayout& layout = kinematics.layout();
  const std::optional<Pose> pose = pose_at(kinematics, q);
  if (!pose) return std::nullopt;
  if (kind == RendererKind::kSubspaceExact) return subspace_impedance(layout, impedance.actuated());

  VecX dx(kinematics.space().n_x());
  kinematics.space().difference(x, pose->x_probe, dx);
  std::optional<FullColumnRank> part;
  if (kind == RendererKind::kNullSpace) part = full_column_rank(pose->J_n);
  if (kind == RendererKind::kSubspaceLinear) part = full_column_rank(pose->J);
  if (kind != RendererKind::kStandard && !part) return std::nullopt;

  const MatAA Z_q = impedance.actuated();
  const VecX f = impedance.Z_x * dx;
  VecQ dq;
  VecX r;
  if (kind == RendererKind::kSubspaceLinear) {
    dq = part->inverse * dx;
    r = part->off * dx;
  }
  MatAQ result(layout.n_a(), layout.n_q());
  for (int k = 0; k < layout.n_q(); ++k) {
    MatXQ J_k;
    if (!derivative_of_J(kinematics, q, k, J_k)) return std::nullopt;
    if (kind == RendererKind::kSubspaceLinear) {
      const VecQ column = linear_column(*part, J_k, dq, r, k);
      result.col(k) = Z_q * layout.select(column);
      continue;
    }
    const MatXQ J_a_k = columns(J_k, layout, true);
    result.col(k) = kind == RendererKind::kStandard
                        ? standard_column(*pose, J_a_k, f, impedance.Z_x, k)
                        : null_space_column(*pose, *part, J_a_k, columns(J_k, layout, false), f,
                                            impedance.Z_x, k);
  }
  return result;
}

std::optional<MatAX> proxy_gain(RendererKind kind, const Kinematics& kinematics, const VecQ& q,
                                const VecX& x, const VecQ& q_star,
                                const RenderingImpedance& impedance) {
  const DofLayout& layout = kinematics.layout();
  if (kind == RendererKind::kSubspaceExact) {
    const std::optional<MatAX> G = exact_proxy_motion(kinematics, x, q_star);
    if (!G) return std::nullopt;
    return actuated_rows(layout, impedance.actuated(), *G);
  }
  const std::optional<Pose> pose = pose_at(kinematics, q);
  if (!pose) return std::nullopt;
  if (kind == RendererKind::kStandard) return MatAX(pose->J_a.transpose() * impedance.Z_x);
  const std::optional<FullColumnRank> part =
      full_column_rank(kind == RendererKind::kNullSpace ? pose->J_n : pose->J);
  if (!part) return std::nullopt;
  if (kind == RendererKind::kNullSpace) {
    return MatAX(pose->J_a.transpose() * part->off * impedance.Z_x);
  }
  return actuated_rows(layout, impedance.actuated(), part->inverse);
}

}  // namespace haptic::core
