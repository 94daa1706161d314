// Eq. (14). The derivative of dq = J^+ dx with respect to q has two parts: -e_k, which Eq. (9)
// keeps, and -B e_k, the change of J, which it leaves out. B is built column by column from the
// same QR that gives dq: one second derivative of f, one back-substitution and, if dx is not in the
// range of J, one residual term per DoF. Only the symmetric part of the actuated block matters to
// the power, and it is compared with Z_q by the congruence with R, so that no choice of units
// changes the sign.
#include "haptic/core/rendering/linear_certificate.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "haptic/core/linear/householder.hpp"
#include "haptic/core/names.hpp"

namespace haptic::core {

std::string_view name(CertificateStatus status) noexcept {
  static constexpr std::array<std::string_view, 7> kNames{
      "OFF", "COMPUTED", "IDLE", "OTHER_RENDERER", "MAP_FAILED", "NOT_FULL_RANK", "NO_STIFFNESS"};
  return name_of(status, kNames);
}

LinearCertificate::LinearCertificate(const ProjectionModel& model) : coupling_(model.coupling()) {
  if (model.prior()) {
    throw SceneError("passivity certificate: must be absent where there is a prior");
  }
  for (const MapBlock& at : model.blocks()) {
    blocks_.push_back(
        {at, model.metric().of(at.first_x, at.n_x()), householder_kernel(at.n_x(), at.n_q())});
  }
}

Certificate LinearCertificate::at(const Probe& probe, const VecX& dx,
                                  const VecA& stiffness) noexcept {
  Certificate worst;
  worst.status = CertificateStatus::kIdle;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Block& block = blocks_[i];
    const double* first = dx.data() + block.at.first_x;
    if (std::all_of(first, first + block.at.n_x(), [](double d) { return d == 0.0; })) continue;
    const int number = static_cast<int>(i);
    double margin = 0.0;
    const CertificateStatus status = judge(block, probe, dx, stiffness, margin);
    if (status != CertificateStatus::kComputed) return {status, number, 0.0};
    if (worst.status == CertificateStatus::kIdle || margin < worst.margin) {
      worst = {status, number, margin};
    }
  }
  return worst;
}

CertificateStatus LinearCertificate::judge(const Block& block, const Probe& probe, const VecX& dx,
                                           const VecA& stiffness, double& margin) noexcept {
  const MapBlock& at = block.at;
  const int n_q = at.n_q(), n_a = at.n_a(), n_x = at.n_x();
  const DofLayout& layout = at.kinematics->layout();
  const double* K = stiffness.data() + at.first_a;
  if (!std::all_of(K, K + n_a, [](double k) { return k > 0.0; })) {
    return CertificateStatus::kNoStiffness;
  }
  q_ = probe.q.segment(at.first_q, n_q);
  J_ = probe.J.block(at.first_x, at.first_q, n_x, n_q);
  r_ = dx.segment(at.first_x, n_x);
  block.metric.weigh(J_);
  block.metric.weigh(r_);
  if (!solve(block, r_, dq_)) return CertificateStatus::kNotFullRank;
  r_ -= J_.lazyProduct(dq_);

  M_.setIdentity(n_a, n_a);
  if (coupling_) turn_.resize(n_a, n_a);
  for (int i = 0; i < n_a; ++i) {
    if (at.kinematics->second_order(q_, layout.actuated(i), J_k_) != MapStatus::kOk) {
      return CertificateStatus::kMapFailed;
    }
    block.metric.weigh(J_k_);
    turned_ = J_k_.lazyProduct(dq_);
    if (!solve(block, turned_, column_)) return CertificateStatus::kNotFullRank;
    if (n_x > n_q) take_off_residual(block, column_);  // of a square J r is 0
    for (int j = 0; j < n_a; ++j) {
      if (coupling_) {
        turn_(j, i) = std::sqrt(K[j] / K[i]) * column_[layout.actuated(j)];
        continue;
      }
      const double half = 0.5 * std::sqrt(K[j] / K[i]) * column_[layout.actuated(j)];
      M_(j, i) += half;
      M_(i, j) += half;
    }
  }
  if (coupling_) couple(*coupling_);
  return smallest_eigenvalue(margin) ? CertificateStatus::kComputed
                                     : CertificateStatus::kNotFullRank;
}

bool LinearCertificate::solve(const Block& block, const VecX& b, VecQ& y) noexcept {
  std::copy_n(J_.data(), block.at.n_x() * block.at.n_q(), A_);
  std::copy_n(b.data(), block.at.n_x(), b_);
  y.resize(block.at.n_q());
  return solve_full_rank(block.kernel, block.at.n_x(), block.at.n_q(), A_, b_, column_norm2_,
                         inverse_diagonal_, y.data())
      .solved;
}

void LinearCertificate::take_off_residual(const Block& block, VecQ& y) noexcept {
  const int m = block.at.n_x(), n = block.at.n_q();
  for (int k = 0; k < n; ++k) {  // R^T p = J_,k^T r
    double p = J_k_.col(k).dot(r_);
    for (int i = 0; i < k; ++i) p -= A_[k * m + i] * b_[i];
    b_[k] = p * inverse_diagonal_[k];
  }
  double solution[kMaxQ];
  block.kernel.back_substitute(m, n, A_, b_, inverse_diagonal_, solution);
  for (int k = 0; k < n; ++k) y[k] -= solution[k];
}

/// R = L^T D: turn_ becomes L^T turn_ L^{-T}.
void LinearCertificate::couple(const StiffnessCoupling& coupling) noexcept {
  const int n = coupling.n_a();
  for (int i = 0; i < n; ++i) {
    VecA column = turn_.col(i);
    coupling.stretch(column);
    turn_.col(i) = column;
  }
  coupling.relax_columns(turn_.data(), n);
  M_ += 0.5 * turn_;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) M_(i, j) += 0.5 * turn_(j, i);
  }
}

bool LinearCertificate::smallest_eigenvalue(double& value) const noexcept {
  if (!M_.allFinite()) return false;
  if (M_.rows() == 1) {
    value = M_(0, 0);
    return true;
  }
  // Bounded, so that it lives on the stack.
  const Eigen::SelfAdjointEigenSolver<MatAA> solver(M_, Eigen::EigenvaluesOnly);
  value = solver.eigenvalues()[0];
  return solver.info() == Eigen::Success;
}

}  // namespace haptic::core
