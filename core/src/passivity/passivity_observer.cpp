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

bool PassivityObserver::moves(const VecA& dq, double T) const noexcept {
  for (Eigen::Index i = 0; i < dq.size(); ++i) {
    const double slowest = settings_.slowest.size() > 0 ? settings_.slowest[i] : 0.0;
    if (std::abs(dq[i] / T) > slowest) return true;
  }
  return false;
}

void PassivityObserver::observe(const HoldAccount& account, const VecA& dq, double T,
                                const SpringStorage& spring) noexcept {
  // E - (V - V[0]) + A: the accepted changes A cancel the jumps of V, what is left is the motion's.
  energy_ += account.limits + account.rendered + account.device_damping - account.leak;
  energy_ = std::min(energy_, settings_.forgetting);
  release();
  const double missing = -(energy_ + settings_.allowance);
  if (!(missing > 0.0) || !(T > 0.0) || !moves(dq, T)) return;
  const VecA& M = settings_.inertia;
  const VecA& K = spring.stiffness;
  VecA D_v;            // of a coupled spring
  double power = 0.0;  // v^T D v
  double alpha_max = std::numeric_limits<double>::infinity();
  if (spring.coupled()) {
    D_v = spring.Z_q.lazyProduct(dq) / T;
    power = D_v.dot(dq) / T;
    for (Eigen::Index i = 0; i < dq.size(); ++i) {
      double sum = 0.0;  // of a row, 1/s^2
      for (Eigen::Index j = 0; j < dq.size(); ++j) {
        sum += std::abs(spring.Z_q(i, j)) / std::sqrt(M[i] * M[j]);
      }
      alpha_max = std::min(alpha_max, 1.0 / (2.0 * T * sum));
    }
  } else {
    for (Eigen::Index i = 0; i < dq.size(); ++i) {
      const double v = dq[i] / T;
      power += v * K[i] * v;
      if (K[i] > 0.0) alpha_max = std::min(alpha_max, M[i] / (2.0 * T * K[i]));
    }
  }
  if (!(power > 0.0)) return;
  alpha_ = std::min(missing / (T * power), alpha_max);
  tau_ = spring.coupled() ? VecA(-alpha_ * D_v) : VecA(-alpha_ * K.cwiseProduct(dq) / T);
}

}  // namespace haptic::core
