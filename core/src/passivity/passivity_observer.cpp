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

double PassivityObserver::missing(const HoldAccount& account) noexcept {
  // E - (V - V[0]) + A: the accepted changes A cancel the jumps of V, what is left is the motion's.
  energy_ += account.limits + account.rendered + account.device_damping - account.leak;
  energy_ = std::min(energy_, settings_.forgetting);
  return -(energy_ + settings_.allowance);
}

bool PassivityObserver::moves(const VecA& dq, double T) const noexcept {
  for (Eigen::Index i = 0; i < dq.size(); ++i) {
    const double slowest = settings_.slowest.size() > 0 ? settings_.slowest[i] : 0.0;
    if (std::abs(dq[i] / T) > slowest) return true;
  }
  return false;
}

void PassivityObserver::observe(const HoldAccount& account, const VecA& dq, double T,
                                const VecA& stiffness) noexcept {
  const double missing = this->missing(account);
  release();
  if (!(missing > 0.0) || !(T > 0.0)) return;
  double power = 0.0;  // v^T D v
  double alpha_max = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < dq.size(); ++i) {
    const double v = dq[i] / T;
    power += v * stiffness[i] * v;
    if (stiffness[i] > 0.0) {
      alpha_max = std::min(alpha_max, settings_.inertia[i] / (2.0 * T * stiffness[i]));
    }
  }
  if (!moves(dq, T) || !(power > 0.0)) return;
  alpha_ = std::min(missing / (T * power), alpha_max);
  tau_ = -alpha_ * stiffness.cwiseProduct(dq) / T;
}

void PassivityObserver::observe(const HoldAccount& account, const VecA& dq, double T,
                                const MatAA& Z_q) noexcept {
  const double missing = this->missing(account);
  release();
  if (!(missing > 0.0) || !(T > 0.0)) return;
  const VecA D_v = Z_q.lazyProduct(dq) / T;
  const double power = D_v.dot(dq) / T;  // v^T D v
  double largest = 0.0;                  // of the rows' sums, 1/s^2
  for (Eigen::Index i = 0; i < dq.size(); ++i) {
    double sum = 0.0;
    for (Eigen::Index j = 0; j < dq.size(); ++j) {
      sum += std::abs(Z_q(i, j)) / std::sqrt(settings_.inertia[i] * settings_.inertia[j]);
    }
    largest = std::max(largest, sum);
  }
  if (!moves(dq, T) || !(power > 0.0)) return;
  alpha_ = std::min(missing / (T * power), 1.0 / (2.0 * T * largest));
  tau_ = -alpha_ * D_v;
}

}  // namespace haptic::core
