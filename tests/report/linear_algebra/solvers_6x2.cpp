#include "tests/report/linear_algebra/solvers.hpp"

namespace haptic::report {

std::vector<Solver> solvers_6x2() {
  return solvers_of_size<6, 2>();
}

}  // namespace haptic::report
