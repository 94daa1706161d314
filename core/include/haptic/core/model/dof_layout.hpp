#pragma once
/// S of the paper as an index list: which DoFs of q are actuated.

#include <initializer_list>
#include <span>

#include "haptic/core/types.hpp"

namespace haptic::core {

class DofLayout {
 public:
  DofLayout() = default;
  /// `actuated[i]` says whether q[i] is actuated. Throws SceneError: none or more than kMaxQ DoFs,
  /// or no actuated one.
  explicit DofLayout(std::span<const bool> actuated);
  DofLayout(std::initializer_list<bool> actuated)
      : DofLayout(std::span<const bool>(actuated.begin(), actuated.size())) {}

  [[nodiscard]] int n_q() const noexcept { return n_q_; }
  [[nodiscard]] int n_a() const noexcept { return n_a_; }
  [[nodiscard]] int n_n() const noexcept { return n_q_ - n_a_; }
  /// Index in q of the i-th actuated (sensed-only) DoF, in the order of q.
  [[nodiscard]] int actuated(int i) const noexcept { return actuated_[i]; }
  [[nodiscard]] int sensed(int i) const noexcept { return sensed_[i]; }

  /// q_a = S q.
  [[nodiscard]] VecA select(const VecQ& q) const noexcept;

 private:
  int n_q_{0};
  int n_a_{0};
  int actuated_[kMaxQ]{};
  int sensed_[kMaxQ]{};
};

}  // namespace haptic::core
