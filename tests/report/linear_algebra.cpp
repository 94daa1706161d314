/// haptic-report linear-algebra: what a small least-squares solve costs and how exact it is,
/// against the condition number of J (core/METHOD.md#solver-error and
/// core/METHOD.md#solver-choice).
#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/bench/paired.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/linear_algebra/problem.hpp"

namespace haptic::report {
namespace {

constexpr int kProblems = 40;  // core/METHOD.md#solver-error

struct Size {
  int m, n;
  std::vector<Solver> solvers;
};

std::vector<Size> sizes() {
  std::vector<Size> all{{2, 2, solvers_2x2()},
                        {6, 2, solvers_6x2()},
                        {6, 6, solvers_6x6()},
                        {27, 10, solvers_27x10()}};
  for (Size& size : all) {
    for (const auto& more : {solvers_own(), solvers_rank_revealing(), solvers_lapack()}) {
      size.solvers.insert(size.solvers.end(), more.begin(), more.end());
    }
  }
  return all;
}

double relative_error(const Size& size, Solve solve, const Problem& problem) {
  std::vector<double> x(static_cast<std::size_t>(size.n), 0.0);
  solve(problem.A.data(), problem.b.data(), x.data(), size.m, size.n);
  double error = 0.0, norm = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    error += (x[i] - problem.x[i]) * (x[i] - problem.x[i]);
    norm += problem.x[i] * problem.x[i];
  }
  return std::sqrt(error / norm);
}

/// NaN counts as the worst there is.
double largest_error(const Size& size, Solve solve, const std::vector<Problem>& set) {
  double worst = 0.0;
  for (const Problem& problem : set) {
    const double error = relative_error(size, solve, problem);
    if (!(error <= worst)) worst = error;
    if (std::isnan(worst)) break;
  }
  return worst;
}

double ns_per_solve(const Size& size, Solve solve, const std::vector<Problem>& set, int calls) {
  double x[16];
  double sink = 0.0;
  const double ns = bench::ns_per_call(calls, [&](int n) {
    for (int i = 0; i < n; ++i) {
      const Problem& problem = set[static_cast<std::size_t>(i % kProblems)];
      solve(problem.A.data(), problem.b.data(), x, size.m, size.n);
      sink += x[0];
    }
  });
  volatile double kept = sink;  // the answers are used
  static_cast<void>(kept);
  return ns;
}

void print_all(int calls) {
  if (solvers_lapack().empty()) {
    std::fprintf(stderr, "linear-algebra: built without LAPACK; its rows are left out\n");
  }
  row("rows", "cols", "method", "cond", "ns", "max_relative_error");
  for (const Size& size : sizes()) {
    for (const Solver& solver : size.solvers) {
      for (int exponent = 0; exponent <= 16; ++exponent) {
        const double cond = std::pow(10.0, exponent);
        const std::vector<Problem> set = problems(size.m, size.n, cond, kProblems, 41);
        row(size.m, size.n, solver.name, cond, ns_per_solve(size, solver.solve, set, calls),
            largest_error(size, solver.solve, set));
      }
    }
  }
}

Solve named(const Size& size, const std::string& name) {
  for (const Solver& solver : size.solvers) {
    if (name == solver.name) return solver.solve;
  }
  return nullptr;
}

/// CONTRIBUTING.md#measuring: alternating blocks of one run, and the errors of both beside the
/// ratio.
void print_paired() {
  constexpr int kCalls = 4000;
  constexpr double kTarget = 1.0 / 2.5;
  bench::print_header();
  for (const Size& size : sizes()) {
    if (size.m > 6) continue;
    const std::vector<Problem> set = problems(size.m, size.n, 10.0, kProblems, 41);
    const Solve own = named(size, "own_qr"), eigen = named(size, "eigen_householder_qr");
    const std::string shape = std::to_string(size.m) + "x" + std::to_string(size.n);
    bench::print(bench::compare(
        "own QR " + shape, "Eigen HouseholderQR", "ns",
        [&] { return ns_per_solve(size, own, set, kCalls); },
        [&] { return ns_per_solve(size, eigen, set, kCalls); }, kTarget));
    std::fprintf(stderr, "linear-algebra: %s at cond 10: error %.1e own, %.1e Eigen\n",
                 shape.c_str(), largest_error(size, own, set), largest_error(size, eigen, set));
  }
}

}  // namespace

void add_linear_algebra(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("linear-algebra", "ns and error of a solve against cond(J)");
  command->footer(
      "Consistent problems, singular values spread evenly in the exponent; the largest relative "
      "error of x over 40 of them, the median time of a solve.");
  struct Options {
    int calls{800};
    bool paired{false};
  };
  auto options = std::make_shared<Options>();
  command->add_option("--calls", options->calls, "solves per figure (800)")
      ->check(CLI::Range(8, 10'000'000));
  command->add_flag("--paired", options->paired,
                    "own QR against Eigen's in alternating blocks instead, as tests/bench does");
  command->callback([options] {
    if (options->paired) {
      print_paired();
    } else {
      print_all(options->calls);
    }
  });
}

}  // namespace haptic::report
