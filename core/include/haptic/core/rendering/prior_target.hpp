#pragma once
/// The pose that the prior draws q* to (core/METHOD.md#projection-algorithm, case B): the live q_a,
/// and q_n^ref, which is q_n at the instant the proxy changed. A live q_n there would make tau_a
/// depend on q_n, and cycles of q pump energy: 11 to 27 % of the loop's work, as measured.

#include "haptic/core/rendering/projection_model.hpp"

namespace haptic::core {

class PriorTarget {
 public:
  /// The target at q, n_q. The first call, and one with `proxy_changed`, takes q_n^ref from q.
  const VecQ& at(const VecQ& q, const DofLayout& layout, bool proxy_changed) noexcept {
    if (proxy_changed || target_.size() != q.size()) target_ = q;
    for (int i = 0; i < layout.n_a(); ++i) target_[layout.actuated(i)] = q[layout.actuated(i)];
    return target_;
  }
  /// The next call takes q_n^ref from q again.
  void reset() noexcept { target_.resize(0); }

 private:
  VecQ target_{};
};

}  // namespace haptic::core
