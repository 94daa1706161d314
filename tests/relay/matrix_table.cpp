#include "tests/relay/matrix_table.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <exception>
#include <fstream>
#include <utility>

namespace haptic::test {
namespace {

std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace

std::string csv_line(const std::string& row, const std::string& expected, const std::string& got,
                     bool passed) {
  return field(row) + ',' + field(expected) + ',' + field(got) + ',' + (passed ? "ok" : "FAILED") +
         '\n';
}

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
  std::ofstream(file, std::ios::app) << csv_line(row_, expected_, got_, passed);
}

}  // namespace haptic::test
