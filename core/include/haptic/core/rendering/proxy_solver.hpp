#pragma once
/// The iteration behind Eq. (6) for a map without a closed form
/// (core/METHOD.md#projection-algorithm):
///   q* = argmin ||x (-) f(q*)||_W^2 + sum_i w_i^2 (q*_i - t_i)^2  over the box of q and the limits
/// of its mechanisms (the ends of sliders),
/// by Gauss-Newton in the box, and by Levenberg-Marquardt if a full step would raise the cost. No
/// step is taken that raises it: the last iterate is the best one seen.

#include "haptic/core/linear/boxed_least_squares.hpp"
#include "haptic/core/rendering/mechanism_limits.hpp"
#include "haptic/core/rendering/projection.hpp"
#include "haptic/core/rendering/projection_model.hpp"

namespace haptic::core {

// The identifier is clang's own, in the copy of an array.
class ProxySolver {  // NOLINT(bugprone-reserved-identifier)
 public:
  static constexpr int kMaxTrials = 8;  ///< of damping, if a Gauss-Newton step fails

  explicit ProxySolver(const ProjectionModel& model);

  /// w and t above, n_q; before the first call there is no prior (w = 0).
  void set_prior(const VecQ& weight, const VecQ& target) noexcept;

  /// From `seed`, moved into the box and, if that succeeds, inside the mechanisms' limits. If J has
  /// not full column rank `stiffness` (n_a) decides which q* is taken. Writes q_star,
  /// status (kConverged, kCapped, kUnreachable, kRankDeficient, kIllConditioned; kMapFailed: f has
  /// no value at the seed), residual, condition. Never allocates.
  void solve(const VecX& x, const VecQ& seed, const VecA& stiffness, Projection& out) noexcept;

 private:
  struct Point {
    VecQ q{};
    VecX x{}, r{};      ///< f(q); W^{1/2} (x (-) f(q))
    MatXQ J{};          ///< W^{1/2} df/dq
    double task{0.0};   ///< ||r||^2
    double cost{0.0};   ///< task and prior; infinite if f has no value
    bool inside{true};  ///< the mechanisms' limits; else there is no cost either
  };
  enum class Step { kTaken, kConverged, kStuck };

  void evaluate(const VecX& x, Point& point) noexcept;
  /// One step from here(), by trial and error; swaps here() and trial() if it was taken.
  [[nodiscard]] Step step(const VecX& x) noexcept;
  [[nodiscard]] Step damped_step(const VecX& x) noexcept;
  /// trial().q = here().q + the step of damping lambda. Returns its length relative to the box.
  double propose(double lambda) noexcept;
  /// trial().q = here().q + share of that step, inside the mechanisms' limits if that succeeds.
  void put_trial(double share) noexcept;
  void follow_curvature(const VecX& x, double promise, bool flat) noexcept;
  /// All rows of the linear problem at here().
  void assemble(double lambda) noexcept;
  [[nodiscard]] Point& here() noexcept { return points_[here_]; }
  [[nodiscard]] Point& trial() noexcept { return points_[1 - here_]; }
  [[nodiscard]] ProjectionStatus judge(Step last) noexcept;
  /// Span of the whole box in X by the Jacobian here, squared.
  [[nodiscard]] double span2() noexcept;

  ProjectionModel model_;
  BoxedLeastSquares linear_{};
  MechanismLimits limits_;
  VecQ lower_{}, upper_{}, metric_root_{};
  bool has_prior_{false};
  VecQ prior_weight_{}, prior_target_{};
  VecQ marquardt_{};  ///< largest column norms so far
  double lambda_{0.0};
  VecQ step_{};          ///< the last proposed, n_q
  bool apart_{true};     ///< its way is known to break no mechanism's limit
  double share_{1.0};    ///< of a step along a curved limit
  double floor_{0.0};    ///< a cost of rounding alone
  double length_{0.0};   ///< of the last undamped step, relative to the box
  bool limited_{false};  ///< of the last undamped step, as are the next two
  double condition_{0.0};
  ProjectionStatus rank_{ProjectionStatus::kNone};
  int here_{0};
  Point points_[2]{};
};

}  // namespace haptic::core
