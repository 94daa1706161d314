#include "haptic/core/projection/task_metric.hpp"

#include <Eigen/Cholesky>
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
  if (!W.allFinite()) throw SceneError("task metric: must be finite");
  // Relative to the diagonal, so that units do not decide what is symmetric.
  const Eigen::VectorXd size = W.diagonal().cwiseAbs().cwiseSqrt();
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      if (std::abs(W(i, j) - W(j, i)) <= 1e-9 * size[i] * size[j]) continue;
      throw SceneError("task metric: entry " + std::to_string(i) + "," + std::to_string(j) +
                       " differs from its mirror image: must be symmetric");
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> cholesky(0.5 * (W + W.transpose()));
  if (cholesky.info() != Eigen::Success) {
    throw SceneError("task metric: must be positive definite");
  }
  TaskMetric metric;
  metric.n_x_ = static_cast<int>(W.rows());
  metric.upper_ = std::make_shared<const Eigen::MatrixXd>(cholesky.matrixU());
  return metric;
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

}  // namespace haptic::core
