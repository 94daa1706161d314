#include "tests/relay/matrix_table.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <exception>
#include <fstream>
#include <utility>

#include "tests/support/csv.hpp"

namespace haptic::test {
MatrixRow::MatrixRow(std::string row, std::string expected)
    : row_(std::move(row)), expected_(std::move(expected)) {}

void MatrixRow::got(const std::string& part) {
  got_ += (got_.empty() ? "" : "; ") + part;
}

MatrixRow::~MatrixRow() {
  const char* file = std::getenv("HAPTIC_MATRIX_CSV");
  if (file == nullptr || *file == '\0') return;
  // An exception on its way out is no failure of the test yet, but will be.
  const bool passed = !testing::Test::HasFailure() && std::uncaught_exceptions() == 0;
  // One write per row, so that rows of programs that run side by side do not mix.
  std::ofstream(file, std::ios::app) << csv_field(row_) + ',' + csv_field(expected_) + ',' +
                                            csv_field(got_) + (passed ? ",ok\n" : ",FAILED\n");
}

}  // namespace haptic::test
