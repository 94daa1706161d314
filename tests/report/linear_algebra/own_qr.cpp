#include <algorithm>

#include "haptic/core/linear/householder.hpp"
#include "tests/report/linear_algebra/problem.hpp"

namespace haptic::report {
namespace {

constexpr int kRows = 27, kCols = 10;  // the largest problem

void own_qr(const double* A, const double* b, double* x, int m, int n) {
  // Chosen once per size, as the product does when it is built.
  static core::HouseholderKernel kernel{};
  static int rows = 0, cols = 0;
  if (rows != m || cols != n) {
    kernel = core::householder_kernel(m, n);
    rows = m;
    cols = n;
  }
  double R[kRows * kCols], y[kRows], norms[kCols], inverse_diagonal[kCols];
  std::copy(A, A + m * n, R);
  std::copy(b, b + m, y);
  kernel.factor(m, n, R, y, norms, inverse_diagonal);
  kernel.back_substitute(m, n, R, y, inverse_diagonal, x);
}

}  // namespace

std::vector<Solver> solvers_own() {
  return {{"own_qr", &own_qr}};
}

}  // namespace haptic::report
