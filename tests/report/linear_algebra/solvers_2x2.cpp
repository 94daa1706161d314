#include "tests/report/linear_algebra/solvers.hpp"

namespace haptic::report {

std::vector<Solver> solvers_2x2() {
  return solvers_of_size<2, 2>();
}

}  // namespace haptic::report
