#include "tests/support/loop/local_laws.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::test {
namespace {

using core::VecQ;
using core::VecX;

/// Half the squared distance from `aim` in the metric (1, M_n / Z_q) of
/// core/METHOD.md#local-models.
class Distance {
 public:
  Distance(const QMetric& what, VecQ aim) : what_(what), aim_(std::move(aim)) {
    constexpr double kLength = 0.02;  // m/rad, core/METHOD.md#local-models
    weight_.setConstant(what.sensed_weight * kLength * kLength);
    weight_[what.finger->layout().actuated(0)] = 1.0;
  }
  /// Value at f^-1(x), which goes to q; infinite if x is out of reach.
  [[nodiscard]] double at(const VecX& x, VecQ& q) const {
    q = aim_;
    if (what_.finger->inverse(x, q) != core::InverseStatus::kExact) {
      return std::numeric_limits<double>::infinity();
    }
    const Eigen::Vector2d d(q[0] - aim_[0], q[1] - aim_[1]);
    return 0.5 * d.dot(weight_.cwiseProduct(d));
  }
  /// Gauss and Newton's step of x_j at q.
  [[nodiscard]] double step(const VecQ& q, int j) const {
    VecX x(2);
    core::MatXQ J(2, 2);
    if (what_.finger->evaluate(q, x, J) != core::MapStatus::kOk) return 0.0;
    const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
    const Eigen::Vector2d slope =  // dq/dx_j: column j of J^-1
        (j == 0 ? Eigen::Vector2d(J(1, 1), -J(1, 0)) : Eigen::Vector2d(-J(0, 1), J(0, 0))) / det;
    const Eigen::Vector2d M_slope = weight_.cwiseProduct(slope);
    const Eigen::Vector2d d(q[0] - aim_[0], q[1] - aim_[1]);
    return -M_slope.dot(d) / M_slope.dot(slope);
  }

 private:
  const QMetric& what_;
  VecQ aim_;
  Eigen::Vector2d weight_;
};

/// The nearest x with x_i on its stop and x_j within its own, from `x`. Returns its distance.
double along_edge(const Distance& distance, const QMetric& what, int i, VecX& x) {
  const int j = 1 - i;
  x[i] = what.stop[i];
  x[j] = std::min(x[j], what.stop[j]);
  VecQ q(2);
  double best = distance.at(x, q);
  for (int iteration = 0; iteration < 50 && std::isfinite(best); ++iteration) {
    double step = std::min(x[j] + distance.step(q, j), what.stop[j]) - x[j];
    bool nearer = false;
    for (int halved = 0; halved < 30 && !nearer; ++halved, step *= 0.5) {
      VecX trial = x;
      trial[j] += step;
      VecQ q_trial(2);
      const double d = distance.at(trial, q_trial);
      if (!(d < best)) continue;
      nearer = true;
      x = trial;
      q = q_trial;
      best = d;
    }
    if (!nearer || std::abs(step) < 1e-11) break;
  }
  return best;
}

}  // namespace

LocalLaw held_deviation() {
  return [](const Between& b) { return VecX(b.x_probe + b.newest.x - b.newest.x_probe); };
}

LocalLaw extrapolated() {
  return [](const Between& b) {
    const double period = b.newest.seen_s - b.previous.seen_s;
    if (!(period > 0.0)) return b.newest.x;
    const double ahead = std::min(b.since_arrival_s, period) / period;
    return VecX(b.newest.x + ahead * (b.newest.x - b.previous.x));
  };
}

LocalLaw q_metric(const QMetric& what) {
  return [what](const Between& b) {
    VecQ aim = b.newest.q;
    const int a = what.finger->layout().actuated(0);
    aim[a] = b.q[a];
    VecX x(2);
    core::MatXQ J(2, 2);
    if (what.finger->evaluate(aim, x, J) != core::MapStatus::kOk) return b.x_probe;
    if ((x.array() <= what.stop.array()).all()) return x;
    const Distance distance(what, aim);
    VecX best = b.x_probe.cwiseMin(what.stop);
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 2; ++i) {
      if (!std::isfinite(what.stop[i])) continue;
      VecX on_edge = x;
      const double d = along_edge(distance, what, i, on_edge);
      if (!(d < least)) continue;
      least = d;
      best = on_edge;
    }
    return best;
  };
}

}  // namespace haptic::test
