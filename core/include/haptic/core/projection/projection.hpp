#pragma once
/// What a renderer is given and what it answers (core/METHOD.md#fig-4 and
/// core/METHOD.md#nonlinear-projection).

#include <cstdint>
#include <string_view>

#include "haptic/core/types.hpp"

namespace haptic::core {

enum class ProjectionStatus : std::uint8_t {
  kNone = 0,            ///< nothing to project: no proxy, or free
  kExact = 1,           ///< solved to rounding (closed form, or a direct linear solve)
  kConverged = 2,       ///< iterated to tolerance
  kCapped = 3,          ///< iteration cap reached; the best iterate is used
  kUnreachable = 4,     ///< no q reaches x; the constrained optimum is used
  kIllConditioned = 5,  ///< condition of the equilibrated J above 1e8
  kRankDeficient = 6,   ///< a column of J depends on the others; minimum-norm answer in metric Z_q
  kMapFailed = 7,       ///< f has no value at q: the last q* is kept
                        ///< (core/METHOD.md#map-without-a-value)
};

[[nodiscard]] std::string_view name(ProjectionStatus status) noexcept;  ///< "EXACT", ...

/// The device in X at this tick. References must outlive the call only.
struct Probe {
  const VecQ& q;
  const VecX& x_probe;
  const MatXQ& J;
};

struct Projection {
  VecQ q_star{};  ///< n_q; where the spring is anchored
  ProjectionStatus status{ProjectionStatus::kNone};
  double residual{0.0};   ///< ||x (-) f(q*)||_W (exact) or ||dx - J dq||_W (linearised)
  double condition{0.0};  ///< max|R_kk|/min|R_kk| of the equilibrated J; 0 where J was not used
  /// With a prior: what its springs store beside 1/2 ||q*_a - q_a||^2_{Z_q}, J (core/METHOD.md#projection-algorithm, case B);
  /// the sum is the potential whose gradient tau_a is. 0 without a prior.
  double storage{0.0};
};

}  // namespace haptic::core
