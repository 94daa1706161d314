/// Ceres' TinySolver: Levenberg-Marquardt on the normal equations, sizes known to the compiler.
#include "tests/report/work_precision/method.hpp"

#ifdef HAPTIC_REPORT_HAS_TINY_SOLVER
#include <ceres/tiny_solver.h>

#include <algorithm>

namespace haptic::report {
namespace {

/// r = f(q) - x and J, column by column; X is linear on these maps.
template <int M, int N>
struct Residual {
  using Scalar = double;
  // NOLINTNEXTLINE(readability-identifier-naming): TinySolver's names
  enum { NUM_RESIDUALS = M, NUM_PARAMETERS = N };

  bool operator()(const double* q, double* residual, double* jacobian) const {
    at = Eigen::Map<const Eigen::Matrix<double, N, 1>>(q);
    if (map->evaluate(at, image, J) != core::MapStatus::kOk) return false;
    const core::VecX r = image - *x;
    std::copy(r.data(), r.data() + M, residual);
    if (jacobian != nullptr) std::copy(J.data(), J.data() + M * N, jacobian);
    return true;
  }

  const core::Kinematics* map{nullptr};
  const core::VecX* x{nullptr};
  mutable core::VecQ at{};
  mutable core::VecX image{};
  mutable core::MatXQ J{};
};

template <int M, int N>
class Tiny final : public Method {
 public:
  explicit Tiny(const core::Kinematics& map) : Method("ceres_tiny_solver_warm") {
    residual_.map = &map;
    solver_.options.gradient_tolerance = 1e-12;
    solver_.options.parameter_tolerance = 1e-12;
    solver_.options.cost_threshold = 1e-28;  // compared with 1/2 ||r||^2
  }
  void begin(const core::VecQ& q) override { parameters_ = q; }
  const core::VecQ& solve(const core::VecQ&, const core::VecX& x) override {
    residual_.x = &x;
    solver_.Solve(residual_, &parameters_);
    q_star_ = parameters_;
    return q_star_;
  }

 private:
  Residual<M, N> residual_{};
  ceres::TinySolver<Residual<M, N>> solver_{};
  Eigen::Matrix<double, N, 1> parameters_{};
  core::VecQ q_star_{};
};

}  // namespace

Methods tiny_solver_methods(const core::Kinematics& map) {
  Methods all;
  const int m = map.space().n_x(), n = map.layout().n_q();
  if (m == 2 && n == 2) all.push_back(std::make_unique<Tiny<2, 2>>(map));
  if (m == 10 && n == 10) all.push_back(std::make_unique<Tiny<10, 10>>(map));
  if (m == 33 && n == 16) all.push_back(std::make_unique<Tiny<33, 16>>(map));
  if (m == 9 && n == 6) all.push_back(std::make_unique<Tiny<9, 6>>(map));
  return all;
}

}  // namespace haptic::report
#else
namespace haptic::report {

Methods tiny_solver_methods(const core::Kinematics&) {
  return {};
}

}  // namespace haptic::report
#endif
