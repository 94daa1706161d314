#include "tests/report/linear_algebra/solvers.hpp"

namespace haptic::report {

std::vector<Solver> solvers_6x6() {
  return solvers_of_size<6, 6>();
}

}  // namespace haptic::report
