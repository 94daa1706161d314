#pragma once
/// The matrix of tests/relay/README.md#rows as a table: tests/relay/matrix.sh names a file in
/// HAPTIC_MATRIX_CSV, and every row that ran appends `row,expected,got,verdict` to it. Without that
/// variable nothing is written.

#include <string>

namespace haptic::test {

/// One row, written when it ends: passed if nothing of the test has failed by then.
class MatrixRow {
 public:
  /// `row`: "virtual/loss_05".
  MatrixRow(std::string row, std::string expected);
  ~MatrixRow();
  MatrixRow(const MatrixRow&) = delete;
  MatrixRow& operator=(const MatrixRow&) = delete;

  /// Adds to the column `got`; parts are joined by "; ".
  void got(const std::string& part);

 private:
  const std::string row_, expected_;
  std::string got_{};
};

}  // namespace haptic::test
