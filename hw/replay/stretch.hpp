#pragma once
/// Rows of a recording without a gap between them, as a curve q(t).

#include <cstdint>
#include <memory>
#include <vector>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/time.hpp"
#include "hw/motion/pchip.hpp"

namespace haptic::hw {

/// Rows as columns: one vector per coordinate or DoF.
using Columns = std::vector<std::vector<double>>;

class Stretch {
 public:
  /// Device states: `q` by DoF, one value per entry of `time_s`.
  Stretch(const std::vector<double>& time_s, const Columns& q);
  /// Joint angles `x` in reach, and q = f^-1(x) of each row. Between two rows x is interpolated and
  /// taken through the inverse, so that f(q) is the recorded motion. If the curve of x between two
  /// rows leaves the reach (it may along the edge), q is interpolated instead: both agree at the
  /// rows, and read() avoids the search for the nearest pose, which takes 500 times as long.
  Stretch(const std::vector<double>& time_s, const Columns& q, const Columns& x,
          std::shared_ptr<const core::Kinematics> kinematics);

  [[nodiscard]] core::Duration begin() const noexcept { return begin_; }
  [[nodiscard]] core::Duration end() const noexcept { return end_; }
  /// q (n_q, sized by the caller) at `t` s, begin() to end(). Allocates nothing.
  void at(double t, core::VecQ& q) const noexcept;

 private:
  [[nodiscard]] bool leaves_reach(double from, double to) const;

  core::Duration begin_;
  core::Duration end_;
  std::vector<Pchip> q_{};
  std::vector<Pchip> x_{};                ///< empty for device states
  std::vector<std::uint8_t> in_reach_{};  ///< by interval: x is interpolated there
  std::shared_ptr<const core::Kinematics> kinematics_{};
};

}  // namespace haptic::hw
