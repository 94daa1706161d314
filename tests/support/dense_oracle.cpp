#include "tests/support/dense_oracle.hpp"

#include <Eigen/Dense>
#include <limits>

namespace haptic::oracle {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd singular_values(const MatrixXd& A) {
  return Eigen::JacobiSVD<MatrixXd>(A).singularValues();
}

double condition(const MatrixXd& A) {
  const VectorXd s = singular_values(A);
  const double smallest = s[s.size() - 1];
  return smallest > 0.0 ? s[0] / smallest : std::numeric_limits<double>::infinity();
}

VectorXd least_squares(const MatrixXd& A, const VectorXd& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  if (threshold >= 0.0) decomposition.setThreshold(threshold);
  decomposition.compute(A);
  return decomposition.solve(b);
}

VectorXd least_squares_in_metric(const MatrixXd& A, const VectorXd& b, const VectorXd& M,
                                 double threshold) {
  const VectorXd root = M.cwiseSqrt().cwiseInverse();
  return root.cwiseProduct(least_squares(A * root.asDiagonal(), b, threshold));
}

VectorXd weighted_least_squares(const MatrixXd& A, const MatrixXd& W, const VectorXd& b) {
  const MatrixXd A_t_W = A.transpose() * W;
  return MatrixXd(A_t_W * A).ldlt().solve(A_t_W * b);
}

MatrixXd inverse(const MatrixXd& A) {
  return A.fullPivLu().inverse();
}

MatrixXd off_columns(const MatrixXd& A) {
  MatrixXd N = MatrixXd::Identity(A.rows(), A.rows());
  if (A.cols() > 0) N -= A * inverse(A.transpose() * A) * A.transpose();
  return N;
}

MatrixXd null_space(const MatrixXd& A) {
  return A.fullPivLu().kernel();
}

MatrixXd orthonormal_basis(const MatrixXd& A) {
  return Eigen::HouseholderQR<MatrixXd>(A).householderQ() * MatrixXd::Identity(A.rows(), A.cols());
}

double smallest_eigenvalue(const MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

MatrixXd product(const MatrixXd& A, const MatrixXd& B) {
  return A * B;
}

}  // namespace haptic::oracle
