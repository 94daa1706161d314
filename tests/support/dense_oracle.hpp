#pragma once
/// Dense linear algebra as the word of another: Eigen's decompositions behind plain functions, for
/// tests that compare the product's own kernels against them. Eigen instantiates a decomposition
/// again in every file that uses it, ten to thirty seconds each; here it happens once.
/// Any sizes unless noted; nothing here uses the product's code. Allocates.

#include <Eigen/Core>

namespace haptic::oracle {

/// Descending, min(m, n) of them (Jacobi SVD).
[[nodiscard]] Eigen::VectorXd singular_values(const Eigen::MatrixXd& A);

/// Largest by smallest singular value; infinite if the smallest is 0.
[[nodiscard]] double condition(const Eigen::MatrixXd& A);

/// y of smallest ||y|| among argmin ||A y - b|| (complete orthogonal decomposition). Singular
/// directions below `threshold` relative to the largest pivot count as lost; < 0: Eigen's default.
[[nodiscard]] Eigen::VectorXd least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                            double threshold = -1.0);

/// y of smallest ||diag(M)^{1/2} y|| among argmin ||A y - b||, M > 0.
[[nodiscard]] Eigen::VectorXd least_squares_in_metric(const Eigen::MatrixXd& A,
                                                      const Eigen::VectorXd& b,
                                                      const Eigen::VectorXd& M, double threshold);

/// y of min ||A y - b||_W, full column rank, from the normal equations (A^T W A) y = A^T W b.
[[nodiscard]] Eigen::VectorXd weighted_least_squares(const Eigen::MatrixXd& A,
                                                     const Eigen::MatrixXd& W,
                                                     const Eigen::VectorXd& b);

/// Inverse of a square matrix (LU with full pivoting).
[[nodiscard]] Eigen::MatrixXd inverse(const Eigen::MatrixXd& A);

/// I - A (A^T A)^{-1} A^T, full column rank; the identity if A has no columns.
[[nodiscard]] Eigen::MatrixXd off_columns(const Eigen::MatrixXd& A);

/// Columns that span the null space; one column of zeros if there is none.
[[nodiscard]] Eigen::MatrixXd null_space(const Eigen::MatrixXd& A);

/// Orthonormal columns with the span of A's; rows >= columns, full column rank.
[[nodiscard]] Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& A);

/// Smallest eigenvalue of a symmetric matrix; only its lower triangle is read.
[[nodiscard]] double smallest_eigenvalue(const Eigen::MatrixXd& A);

/// A B: in a test file of its own the general product alone costs seconds.
[[nodiscard]] Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

}  // namespace haptic::oracle
