#include "haptic/core/linear/rank_metric.hpp"

#include <cmath>

namespace haptic::core {

VecQ rank_metric_root(const MatXQ& J, const DofLayout& layout, const VecA& Z_q) noexcept {
  VecQ weight = VecQ::Ones(layout.n_q());
  double z_x = 0.0;
  int counted = 0;
  for (int i = 0; i < layout.n_a(); ++i) {
    const double column = J.col(layout.actuated(i)).squaredNorm();
    if (column > 0.0 && Z_q[i] > 0.0) {
      z_x += Z_q[i] / column;
      ++counted;
    }
  }
  z_x = counted > 0 ? z_x / counted : 1.0;
  for (int i = 0; i < layout.n_a(); ++i) {
    if (Z_q[i] > 0.0) weight[layout.actuated(i)] = 1.0 / std::sqrt(Z_q[i]);
  }
  for (int i = 0; i < layout.n_n(); ++i) {
    const double column = J.col(layout.sensed(i)).squaredNorm();
    if (column > 0.0) weight[layout.sensed(i)] = 1.0 / std::sqrt(z_x * column);
  }
  return weight;
}

}  // namespace haptic::core
