#include "haptic/core/model/task_metric.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <charconv>
#include <cmath>
#include <string>

#include "haptic/core/error.hpp"

namespace haptic::core {

namespace {

void require_size(Eigen::Index n, const char* what) {
  if (n >= 1 && n <= kMaxX) return;
  throw SceneError(std::string("task metric with ") + std::to_string(n) + " " + what +
                   ": must be 1 to " + std::to_string(kMaxX));
}

std::string text(double value) {
  char digits[32];
  const auto written =
      std::to_chars(digits, digits + sizeof digits, value, std::chars_format::general, 6);
  return {digits, written.ptr};
}

/// "W(i, j) = value".
std::string entry(const Eigen::Ref<const Eigen::MatrixXd>& W, Eigen::Index i, Eigen::Index j) {
  return "W(" + std::to_string(i) + ", " + std::to_string(j) + ") = " + text(W(i, j));
}

void require_symmetric(const Eigen::Ref<const Eigen::MatrixXd>& W) {
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    if (!W.row(i).allFinite()) throw SceneError("task metric: W must be finite");
    if (!(W(i, i) > 0.0)) {
      throw SceneError("task metric: " + entry(W, i, i) + ": must be > 0 on the diagonal");
    }
    for (Eigen::Index j = 0; j < i; ++j) {
      // Relative to the diagonal, so that units do not decide what is symmetric.
      if (std::abs(W(i, j) - W(j, i)) <= 1e-9 * std::sqrt(W(i, i) * W(j, j))) continue;
      throw SceneError("task metric: " + entry(W, i, j) + ": must be symmetric, " + entry(W, j, i));
    }
  }
}

/// `symmetric`: with a diagonal > 0.
void require_positive_definite(const Eigen::MatrixXd& symmetric) {
  const Eigen::VectorXd scale = symmetric.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * symmetric * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled, Eigen::EigenvaluesOnly);
  const double least = solver.eigenvalues()[0];
  if (least > TaskMetric::kLeastEigenvalue) return;
  throw SceneError(
      "task metric: W must be positive definite; with its diagonal scaled to 1 its smallest "
      "eigenvalue is " +
      text(least) + ", must be > " + text(TaskMetric::kLeastEigenvalue));
}

/// (U^T U)^-1.
std::shared_ptr<const Eigen::MatrixXd> inverse_of(const Eigen::MatrixXd& U) {
  const Eigen::Index n = U.rows();
  const Eigen::MatrixXd root =
      U.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(n, n));
  return std::make_shared<const Eigen::MatrixXd>(root * root.transpose());
}

}  // namespace

TaskMetric TaskMetric::from_scales(const VecX& scale) {
  require_size(scale.size(), "scales");
  TaskMetric metric;
  metric.n_x_ = static_cast<int>(scale.size());
  metric.diagonal_ = scale.cwiseInverse();
  for (int i = 0; i < metric.n_x_; ++i) {
    if (!(scale[i] > 0.0 && std::isfinite(scale[i]) && std::isfinite(metric.diagonal_[i]))) {
      throw SceneError("task metric: scale[" + std::to_string(i) +
                       "] = " + std::to_string(scale[i]) + ": must be finite and > 0");
    }
  }
  return metric;
}

TaskMetric TaskMetric::from_matrix(const Eigen::Ref<const Eigen::MatrixXd>& W) {
  require_size(W.rows(), "rows");
  if (W.cols() != W.rows()) {
    throw SceneError("task metric of " + std::to_string(W.rows()) + " x " +
                     std::to_string(W.cols()) + ": must be square");
  }
  require_symmetric(W);
  const Eigen::MatrixXd symmetric = 0.5 * (W + W.transpose());
  require_positive_definite(symmetric);
  TaskMetric metric;
  metric.n_x_ = static_cast<int>(W.rows());
  if (symmetric.isDiagonal(0.0)) {
    metric.diagonal_ = symmetric.diagonal().cwiseSqrt();
  } else {
    metric.upper_ =
        std::make_shared<const Eigen::MatrixXd>(Eigen::LLT<Eigen::MatrixXd>(symmetric).matrixU());
    metric.inverse_ = inverse_of(*metric.upper_);
  }
  return metric;
}

Eigen::MatrixXd TaskMetric::matrix() const {
  if (upper_ != nullptr) return upper_->transpose() * *upper_;
  return Eigen::MatrixXd(diagonal_.cwiseAbs2().asDiagonal());
}

/// W and its triangular root have the same blocks.
bool TaskMetric::separates(int first, int count) const noexcept {
  if (upper_ == nullptr) return true;
  const Eigen::Index end = first + count, after = n_x_ - end;
  return (upper_->block(0, first, first, count).array() == 0.0).all() &&
         (upper_->block(first, end, count, after).array() == 0.0).all();
}

TaskMetric TaskMetric::of(int first, int count) const {
  TaskMetric metric;
  if (is_identity()) return metric;
  metric.n_x_ = count;
  if (upper_ == nullptr) {
    metric.diagonal_ = diagonal_.segment(first, count);
  } else {
    metric.upper_ =
        std::make_shared<const Eigen::MatrixXd>(upper_->block(first, first, count, count));
    metric.inverse_ = inverse_of(*metric.upper_);
  }
  return metric;
}

bool TaskMetric::is_uniform(int first, int count) const noexcept {
  if (is_identity()) return true;
  for (int i = first; i < first + count; ++i) {
    if (upper_ == nullptr) {
      if (diagonal_[i] != diagonal_[first]) return false;
      continue;
    }
    if ((*upper_)(i, i) != (*upper_)(first, first)) return false;
    for (int j = i + 1; j < first + count; ++j) {
      if ((*upper_)(i, j) != 0.0) return false;
    }
  }
  return true;
}

void TaskMetric::weigh(double* column) const noexcept {
  if (upper_ == nullptr) {
    for (int i = 0; i < n_x_; ++i) column[i] *= diagonal_[i];
    return;
  }
  for (int i = 0; i < n_x_; ++i) {  // row i reads only what is still as it was
    double sum = 0.0;
    for (int j = i; j < n_x_; ++j) sum += (*upper_)(i, j) * column[j];
    column[i] = sum;
  }
}

void TaskMetric::weigh(VecX& v) const noexcept {
  if (!is_identity()) weigh(v.data());
}

void TaskMetric::weigh(MatXQ& J) const noexcept {
  if (is_identity()) return;
  for (Eigen::Index k = 0; k < J.cols(); ++k) weigh(J.data() + k * J.rows());
}

const VecX& TaskMetric::weighed(const VecX& v, VecX& scratch) const noexcept {
  if (is_identity()) return v;
  scratch = v;
  weigh(scratch.data());
  return scratch;
}

const MatXQ& TaskMetric::weighed(const MatXQ& J, MatXQ& scratch) const noexcept {
  if (is_identity()) return J;
  scratch = J;
  weigh(scratch);
  return scratch;
}

VecX TaskMetric::steepest(const VecX& a, int first, int count) const noexcept {
  if (is_identity()) return a;
  if (upper_ == nullptr) return a.cwiseQuotient(diagonal_.cwiseAbs2());
  VecX d = VecX::Zero(n_x_);
  for (int k = first; k < first + count; ++k) d += a[k] * inverse_->col(k);
  return d;
}

}  // namespace haptic::core
