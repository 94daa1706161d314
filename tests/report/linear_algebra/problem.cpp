#include "tests/report/linear_algebra/problem.hpp"

#include <random>

#include "tests/core/linear/random_matrix.hpp"

namespace haptic::report {

std::vector<Problem> problems(int m, int n, double cond, int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Problem> result;
  for (int i = 0; i < count; ++i) {
    const Eigen::MatrixXd A = core::samples::with_condition(random, m, n, cond);
    const Eigen::VectorXd x = core::samples::gaussian(random, n, 1);
    const Eigen::VectorXd b = A * x;
    result.push_back({{A.data(), A.data() + A.size()},
                      {b.data(), b.data() + b.size()},
                      {x.data(), x.data() + x.size()}});
  }
  return result;
}

}  // namespace haptic::report
