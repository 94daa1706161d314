#include "haptic/core/linear/stiffness_coupling.hpp"

#include <cmath>
#include <string>

#include "haptic/core/error.hpp"

namespace haptic::core {

namespace {

/// Difference of two entries that should be the same, relative to their diagonal: text has 15
/// digits or more.
constexpr double kSameEntry = 1e-12;
/// Square of Cholesky's pivot in C. Below it a direction of q has a millionth of its neighbours'
/// stiffness: a slip of the pen, or a rank that rounding decides.
constexpr double kLeastPivot2 = 1e-12;

std::string named_entry(Eigen::Index i, Eigen::Index j, double value) {
  return "entry (" + std::to_string(i) + ", " + std::to_string(j) + ") = " + std::to_string(value);
}

void require_stiffness_shape(const Eigen::Ref<const Eigen::MatrixXd>& Z) {
  if (Z.rows() == Z.cols() && Z.rows() >= 1 && Z.rows() <= kMaxQ) return;
  throw SceneError("stiffness matrix of " + std::to_string(Z.rows()) + " x " +
                   std::to_string(Z.cols()) + ": must be square, 1 to " + std::to_string(kMaxQ) +
                   " rows");
}

void require_stiffness_symmetric(const Eigen::Ref<const Eigen::MatrixXd>& Z) {
  for (Eigen::Index i = 0; i < Z.rows(); ++i) {
    if (!(Z(i, i) > 0.0) || !std::isfinite(Z(i, i))) {
      throw SceneError("stiffness matrix: " + named_entry(i, i, Z(i, i)) +
                       ", must be finite and > 0");
    }
  }
  for (Eigen::Index i = 0; i < Z.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const double scale = std::sqrt(Z(i, i)) * std::sqrt(Z(j, j));
      if (std::abs(Z(i, j) - Z(j, i)) <= kSameEntry * scale) continue;  // false for a NaN
      throw SceneError("stiffness matrix: " + named_entry(i, j, Z(i, j)) + " and " +
                       named_entry(j, i, Z(j, i)) +
                       ", must be finite and symmetric: another has no potential");
    }
  }
}

}  // namespace

StiffnessCoupling::StiffnessCoupling(const Eigen::Ref<const Eigen::MatrixXd>& Z_q) {
  require_stiffness_shape(Z_q);
  require_stiffness_symmetric(Z_q);
  const Eigen::Index n = Z_q.rows();
  stiffness_ = Z_q.diagonal();
  C_.setIdentity(n, n);
  L_.setZero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      C_(i, j) = C_(j, i) =
          0.5 * (Z_q(i, j) + Z_q(j, i)) / (std::sqrt(stiffness_[i]) * std::sqrt(stiffness_[j]));
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {  // Cholesky, row by row
    double left = 1.0;
    for (Eigen::Index j = 0; j < i; ++j) {
      double sum = C_(i, j);
      for (Eigen::Index k = 0; k < j; ++k) sum -= L_(i, k) * L_(j, k);
      L_(i, j) = sum / L_(j, j);
      left -= L_(i, j) * L_(i, j);
    }
    if (!(left > kLeastPivot2)) {
      throw SceneError("stiffness matrix: must be positive definite, but rows 0 to " +
                       std::to_string(i) + " are not");
    }
    L_(i, i) = std::sqrt(left);
  }
}

bool StiffnessCoupling::is_diagonal() const noexcept {
  for (Eigen::Index i = 0; i < C_.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      if (C_(i, j) != 0.0) return false;
    }
  }
  return true;
}

MatAA StiffnessCoupling::matrix(const VecA& K) const noexcept {
  MatAA Z = C_;
  for (Eigen::Index i = 0; i < Z.rows(); ++i) {
    Z(i, i) = K[i];
    for (Eigen::Index j = 0; j < i; ++j)
      Z(i, j) = Z(j, i) = C_(i, j) * (std::sqrt(K[i]) * std::sqrt(K[j]));
  }
  return Z;
}

void StiffnessCoupling::stretch(VecA& v) const noexcept {
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    double sum = 0.0;
    for (Eigen::Index j = i; j < v.size(); ++j) sum += L_(j, i) * v[j];
    v[i] = sum;
  }
}

void StiffnessCoupling::relax(VecA& v) const noexcept {
  for (Eigen::Index i = v.size() - 1; i >= 0; --i) {
    for (Eigen::Index j = i + 1; j < v.size(); ++j) v[i] -= L_(j, i) * v[j];
    v[i] /= L_(i, i);
  }
}

/// B = A L^{-T}, so B L^T = A: column k of A is sum_j<=k L_kj B_j.
template <typename Column>
void StiffnessCoupling::relax_each(int rows, Column column) const noexcept {
  for (int k = 0; k < n_a(); ++k) {
    double* const a = column(k);
    for (int j = 0; j < k; ++j) {
      const double* const b = column(j);
      for (int i = 0; i < rows; ++i) a[i] -= L_(k, j) * b[i];
    }
    for (int i = 0; i < rows; ++i) a[i] /= L_(k, k);
  }
}

void StiffnessCoupling::relax_columns(double* A, int rows) const noexcept {
  relax_each(rows, [&](int k) { return A + k * rows; });
}

void StiffnessCoupling::relax_columns(double* A, int rows, const DofLayout& layout) const noexcept {
  relax_each(rows, [&](int k) { return A + layout.actuated(k) * rows; });
}

}  // namespace haptic::core
