#include <Eigen/SVD>

#include "tests/report/linear_algebra/solvers.hpp"

namespace haptic::report {
namespace {

using Any = Sized<0, 0>;

void jacobi_svd(const double* A, const double* b, double* x, int m, int n) {
  const Eigen::JacobiSVD<Any::Matrix> svd(Any::matrix(A, m, n),
                                          Eigen::ComputeThinU | Eigen::ComputeThinV);
  Any::answer(x, n) = svd.solve(Any::right(b, m));
}

}  // namespace

std::vector<Solver> solvers_rank_revealing() {
  return {{"eigen_cod", &Any::eigen<Eigen::CompleteOrthogonalDecomposition<Any::Matrix>>},
          {"eigen_jacobi_svd", &jacobi_svd}};
}

}  // namespace haptic::report
