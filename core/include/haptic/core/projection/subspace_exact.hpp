#pragma once
/// Eq. (6): q* = argmin ||x (-) f(q*)||^2 over the box of q*, solved once per change of the proxy
/// (METHOD 3.3, case A: full column rank). By the map's closed form where it offers one; otherwise
/// by Gauss-Newton from the last q*, each step a least-squares problem in the box, halved until the
/// cost does not rise.

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/projection/projection.hpp"

namespace haptic::core {

class SubspaceExact {
 public:
  static constexpr int kMaxSteps = 10;    ///< Gauss-Newton steps per change of the proxy
  static constexpr int kMaxHalvings = 8;  ///< of one step
  static constexpr double kTolerance =
      1e-12;  ///< step relative to the box, that ends the iteration

  explicit SubspaceExact(const Kinematics& kinematics);
  void project(const Probe& probe, const VecX& x, const VecA& stiffness, bool proxy_changed,
               Projection& out) noexcept;
  void reset() noexcept { has_solution_ = false; }

 private:
  void iterate(const VecX& x, const VecA& stiffness) noexcept;
  /// One Gauss-Newton step from q_ that stays in the box; active set, at most 2 n_q passes.
  void box_step(const VecA& stiffness) noexcept;
  [[nodiscard]] double cost_at(const VecQ& q, const VecX& x) noexcept;

  const Kinematics* kinematics_;
  LeastSquares solver_;
  bool has_solution_{false};
  Projection solution_{};
  VecQ lower_{}, upper_{};
  VecQ q_{}, trial_{}, step_{};
  VecX x_at_{}, r_{}, rhs_{};
  MatXQ J_{}, J_free_{};
};

}  // namespace haptic::core
