#include "haptic/core/passivity/passivity_observer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::core {

PassivityObserver::PassivityObserver(const ObserverSettings& settings, int n_a)
    : settings_(settings), tau_(VecA::Zero(n_a)) {}

void PassivityObserver::restart() noexcept {
  energy_ = 0.0;
  release();
}

void PassivityObserver::release() noexcept {
  alpha_ = 0.0;
  tau_.setZero();
}

void PassivityObserver::observe(const HoldAccount& account, const VecA& dq, double T,
                                const VecA& stiffness) noexcept {
  // E - (V - V[0]) + A: the accepted changes A cancel the jumps of V, what is left is the motion's.
  energy_ += account.limits + account.rendered + account.device_damping - account.leak;
  energy_ = std::min(energy_, settings_.forgetting);

  release();
  const double missing = -(energy_ + settings_.allowance);
  if (!(missing > 0.0) || !(T > 0.0)) return;
  double power = 0.0;  // v^T D v
  double alpha_max = std::numeric_limits<double>::infinity();
  bool moves = false;
  for (Eigen::Index i = 0; i < dq.size(); ++i) {
    const double v = dq[i] / T;
    const double slowest = settings_.slowest.size() > 0 ? settings_.slowest[i] : 0.0;
    moves = moves || std::abs(v) > slowest;
    power += v * stiffness[i] * v;
    if (stiffness[i] > 0.0) {
      alpha_max = std::min(alpha_max, settings_.inertia[i] / (2.0 * T * stiffness[i]));
    }
  }
  if (!moves || !(power > 0.0)) return;
  alpha_ = std::min(missing / (T * power), alpha_max);
  tau_ = -alpha_ * stiffness.cwiseProduct(dq) / T;
}

}  // namespace haptic::core
