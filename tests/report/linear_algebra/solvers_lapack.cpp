/// LAPACK's least squares by rank-revealing QR (dgelsy) and by SVD (dgelsd), through the Fortran
/// interface, work space kept between calls.
#include <algorithm>

#include "tests/report/linear_algebra/problem.hpp"

#ifdef HAPTIC_REPORT_HAS_LAPACK
// Names as LAPACK's Fortran objects have them; no header declares these in Debian's liblapack-dev.
extern "C" {
void dgelsy_(const int* m, const int* n, const int* nrhs, double* A, const int* lda, double* B,
             const int* ldb, int* jpvt, const double* rcond, int* rank, double* work,
             const int* lwork, int* info);
void dgelsd_(const int* m, const int* n, const int* nrhs, double* A, const int* lda, double* B,
             const int* ldb, double* S, const double* rcond, int* rank, double* work,
             const int* lwork, int* iwork, int* info);
}

namespace haptic::report {
namespace {

constexpr int kRows = 27, kCols = 10;  // the largest problem
constexpr int kWork = 8192, kIntegers = 1024;
constexpr double kRcond = -1.0;  // machine precision

struct Space {
  double A[kRows * kCols], B[kRows], S[kCols], work[kWork];
  int pivots[kCols], integers[kIntegers];
};
Space space;

void load(const double* A, const double* b, int m, int n) {
  std::copy(A, A + m * n, space.A);
  std::copy(b, b + m, space.B);
}

void gelsy(const double* A, const double* b, double* x, int m, int n) {
  load(A, b, m, n);
  std::fill(space.pivots, space.pivots + n, 0);  // every column free to move
  const int one = 1, work = kWork;
  int rank = 0, info = 0;
  dgelsy_(&m, &n, &one, space.A, &m, space.B, &m, space.pivots, &kRcond, &rank, space.work, &work,
          &info);
  std::copy(space.B, space.B + n, x);
}

void gelsd(const double* A, const double* b, double* x, int m, int n) {
  load(A, b, m, n);
  const int one = 1, work = kWork;
  int rank = 0, info = 0;
  dgelsd_(&m, &n, &one, space.A, &m, space.B, &m, space.S, &kRcond, &rank, space.work, &work,
          space.integers, &info);
  std::copy(space.B, space.B + n, x);
}

}  // namespace

std::vector<Solver> solvers_lapack() {
  return {{"lapack_dgelsy", &gelsy}, {"lapack_dgelsd", &gelsd}};
}

}  // namespace haptic::report
#else
namespace haptic::report {

std::vector<Solver> solvers_lapack() {
  return {};
}

}  // namespace haptic::report
#endif
