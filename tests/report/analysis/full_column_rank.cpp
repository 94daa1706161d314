#include "tests/report/analysis/full_column_rank.hpp"

#include <Eigen/QR>

#include "haptic/core/linear/householder.hpp"

namespace haptic::core {

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

}  // namespace haptic::core
