#pragma once
/// Least-squares problems of known condition and known answer, and the solvers that are compared on
/// them. Plain arrays, column-major: every solver starts from the same bytes.

#include <cstdint>
#include <vector>

namespace haptic::report {

/// x = argmin ||A x - b||; A is m by n, b has m, x has n numbers. A and b stay as they are.
using Solve = void (*)(const double* A, const double* b, double* x, int m, int n);

struct Solver {
  const char* name;
  Solve solve;
};

struct Problem {
  std::vector<double> A{}, b{}, x{};  ///< b = A x
};

/// Singular values spread evenly in the exponent from 1 to 1/cond, random singular vectors and
/// answer. The same seed gives the same problems.
[[nodiscard]] std::vector<Problem> problems(int m, int n, double cond, int count,
                                            std::uint64_t seed);

/// haptic::core's kernel and back substitution: what a device's tick runs.
[[nodiscard]] std::vector<Solver> solvers_own();
/// Normal equations, Eigen's QR without and with pivoting. One file per size: decompositions
/// of fixed size take the compiler long (core/METHOD.md#solver-choice).
[[nodiscard]] std::vector<Solver> solvers_2x2();
[[nodiscard]] std::vector<Solver> solvers_6x2();
[[nodiscard]] std::vector<Solver> solvers_6x6();
[[nodiscard]] std::vector<Solver> solvers_27x10();
/// Eigen's complete orthogonal decomposition and SVD for any of these sizes, compiled once: of
/// fixed size they take minutes of compile time and gain nothing that shows beside what they cost
/// to run.
[[nodiscard]] std::vector<Solver> solvers_rank_revealing();
/// dgelsy, dgelsd; none where LAPACK was not there when this was built.
[[nodiscard]] std::vector<Solver> solvers_lapack();

}  // namespace haptic::report
