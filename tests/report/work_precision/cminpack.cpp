/// MINPACK's lmder in C: Levenberg-Marquardt by QR, with the Jacobian given.
#include "tests/report/work_precision/method.hpp"

#ifdef HAPTIC_REPORT_HAS_CMINPACK
#include <cminpack.h>

namespace haptic::report {
namespace {

class Lmder final : public Method {
 public:
  explicit Lmder(const core::Kinematics& map) : Method("cminpack_lmder_warm"), map_(map) {}
  void begin(const core::VecQ& q) override { q_star_ = q; }
  const core::VecQ& solve(const core::VecQ&, const core::VecX& x) override {
    constexpr double kTolerance = 1e-12, kFactor = 100.0;  // of lmder's first step: its own advice
    constexpr int kMostCalls = 200, kOwnScale = 1, kNoPrint = 0;
    x_ = &x;
    int calls = 0, jacobians = 0;
    const int m = map_.space().n_x(), n = map_.layout().n_q();
    lmder(&Lmder::residual, this, m, n, q_star_.data(), r_, J_at_, m, kTolerance, kTolerance, 0.0,
          kMostCalls, scale_, kOwnScale, kFactor, kNoPrint, &calls, &jacobians, pivots_, qtf_,
          work1_, work2_, work3_, work4_);
    return q_star_;
  }

 private:
  /// f(q) - x for flag 1, J for flag 2; a negative answer ends lmder.
  static int residual(void* self, int m, int n, const double* q, double* r, double* J_out, int ld,
                      int flag) {
    Lmder& at = *static_cast<Lmder*>(self);
    at.q_ = Eigen::Map<const Eigen::VectorXd>(q, n);
    if (flag == 1) {
      if (at.map_.position(at.q_, at.image_) != core::MapStatus::kOk) return -1;
      Eigen::Map<Eigen::VectorXd>(r, m) = at.image_ - *at.x_;
      return 0;
    }
    if (at.map_.evaluate(at.q_, at.image_, at.J_) != core::MapStatus::kOk) return -1;
    Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>(J_out, m, n, Eigen::OuterStride<>(ld)) =
        at.J_;
    return 0;
  }

  const core::Kinematics& map_;
  const core::VecX* x_{nullptr};
  core::VecQ q_star_{}, q_{};
  core::VecX image_{};
  core::MatXQ J_{};
  double r_[core::kMaxX], J_at_[core::kMaxX * core::kMaxQ], scale_[core::kMaxQ];
  double qtf_[core::kMaxQ], work1_[core::kMaxQ], work2_[core::kMaxQ], work3_[core::kMaxQ];
  double work4_[core::kMaxX];
  int pivots_[core::kMaxQ];
};

}  // namespace

Methods cminpack_methods(const core::Kinematics& map) {
  Methods all;
  all.push_back(std::make_unique<Lmder>(map));
  return all;
}

}  // namespace haptic::report
#else
namespace haptic::report {

Methods cminpack_methods(const core::Kinematics&) {
  return {};
}

}  // namespace haptic::report
#endif
