/// haptic-bench-linear: our Householder QR against Eigen's, ns per least-squares solve and forward
/// error, at the sizes of core/METHOD.md#solver-choice. Our kernel is called as the product calls
/// it, by its pointer.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "haptic/core/linear/householder.hpp"
#include "tests/bench/paired.hpp"

namespace {

using namespace haptic;

constexpr int kProblems = 64;
constexpr int kCalls = 8192;
constexpr double kTarget = 1.0 / 2.5;  // at least 2.5 times faster

double sink = 0.0;

/// Random problems with a known solution: b = A y.
template <int M, int N>
struct Problems {
  using Matrix = Eigen::Matrix<double, M, N>;
  std::vector<Matrix> A{};
  std::vector<Eigen::Matrix<double, M, 1>> b{};
  std::vector<Eigen::Matrix<double, N, 1>> y{};

  Problems() {
    std::srand(1);
    for (int i = 0; i < kProblems; ++i) {
      A.push_back(Matrix::Random());
      y.push_back(Eigen::Matrix<double, N, 1>::Random());
      b.push_back(A.back() * y.back());
    }
  }
};

template <int M, int N>
void own_solve(const core::HouseholderKernel& kernel, const Eigen::Matrix<double, M, N>& A,
               const Eigen::Matrix<double, M, 1>& b, Eigen::Matrix<double, N, 1>& y) {
  alignas(16) double R[M * N], c[M], norm2[N], inverse[N];
  Eigen::Map<Eigen::Matrix<double, M, N>>{R} = A;
  Eigen::Map<Eigen::Matrix<double, M, 1>>{c} = b;
  kernel.factor(M, N, R, c, norm2, inverse);
  sink += core::diagonal_condition2(N, norm2, inverse);  // Eigen's is not asked for its rank
  kernel.back_substitute(M, N, R, c, inverse, y.data());
}

template <int M, int N>
void compare() {
  const Problems<M, N> problems;
  const core::HouseholderKernel kernel = core::householder_kernel(M, N);
  Eigen::Matrix<double, N, 1> y;
  const auto own = [&](int n) {
    for (int i = 0; i < n; ++i) {
      const std::size_t k = static_cast<std::size_t>(i % kProblems);
      own_solve<M, N>(kernel, problems.A[k], problems.b[k], y);
      sink += y[0];
    }
  };
  const auto eigen = [&](int n) {
    for (int i = 0; i < n; ++i) {
      const std::size_t k = static_cast<std::size_t>(i % kProblems);
      y = problems.A[k].householderQr().solve(problems.b[k]);
      sink += y[0];
    }
  };
  const std::string size = std::to_string(M) + "x" + std::to_string(N);
  bench::print(bench::compare("own QR " + size, "fixed-size Eigen HouseholderQR", "ns",
                              bench::ns_block(kCalls, own), bench::ns_block(kCalls, eigen),
                              kTarget));
  double ours = 0.0, theirs = 0.0;
  for (std::size_t k = 0; k < kProblems; ++k) {
    own_solve<M, N>(kernel, problems.A[k], problems.b[k], y);
    ours = std::max(ours, (y - problems.y[k]).norm() / problems.y[k].norm());
    y = problems.A[k].householderQr().solve(problems.b[k]);
    theirs = std::max(theirs, (y - problems.y[k]).norm() / problems.y[k].norm());
  }
  std::printf("# largest relative error of %s: own %.2g, Eigen %.2g\n", size.c_str(), ours, theirs);
}

}  // namespace

int main() {
  bench::print_header();
  compare<2, 2>();
  compare<6, 2>();
  compare<6, 6>();
  compare<27, 10>();
  std::fprintf(stderr, "%s",
               sink == 0.123 ? "\n" : "");  // keeps the work from being optimised away
  return 0;
}
