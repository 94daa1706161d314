#pragma once
/// Forces that are held back: what takes them away, and gives them back, does so no faster than a
/// hand takes for a click.

#include <algorithm>
#include <cmath>

#include "haptic/core/types.hpp"

namespace haptic::core {

/// The share of a wished force that is in use behind the energy tank (core/METHOD.md#energy-tank,
/// Eq. (42)).
class ForceFade {
 public:
  /// s, in which a force as large as the force limit fades: 0.125 N per ms of 25 N.
  static constexpr double kWhole_s = 0.2;

  /// s, in which tau (n_a) fades by its limits (n_a, N or N m).
  [[nodiscard]] static double time(const VecA& tau, const VecA& limit) noexcept {
    double longest = 0.0;
    for (Eigen::Index i = 0; i < tau.size(); ++i) {
      if (tau[i] != 0.0) longest = std::max(longest, std::abs(tau[i]) / limit[i]);
    }
    return kWhole_s * longest;
  }

  void restart() noexcept { share_ = 1.0; }
  [[nodiscard]] double share() const noexcept { return share_; }
  /// The share, as near to `target` as a fade allows: the force keeps near the share of before, or
  /// near the force of before if that is less of a change. `whole` and `last`: time() of the wished
  /// force and of the part of the last one that points the same way.
  double towards(double target, double whole, double last, double tick) noexcept {
    if (!(whole > 0.0)) return share_ = 1.0;
    const double kept = share_ * whole, same = std::min(last, whole);
    const double used =
        std::clamp(target * whole, std::min(kept, same) - tick, std::max(kept, same) + tick);
    return share_ = std::clamp(used / whole, 0.0, 1.0);
  }
  /// More was held back than that.
  void at_most(double share) noexcept { share_ = std::min(share_, share); }

 private:
  double share_{1.0};
};

/// The force in use if contacts or the direction guard allow less than the wished one
/// (core/METHOD.md#forces-that-come-and-go): it never grows towards what is not allowed, and goes
/// and comes as a force that fades.
class EasedForce {
 public:
  /// s, over which noise that decides what is allowed is averaged.
  static constexpr double kSmooth_s = 0.02;

  explicit EasedForce(int n_a) : wish_(VecA::Zero(n_a)), used_(VecA::Zero(n_a)) {}

  void restart() noexcept {
    wish_.setZero();
    used_.setZero();
    whole_ = true;
  }
  /// True: the last force was as wished.
  [[nodiscard]] bool whole() const noexcept { return whole_; }
  /// A tick that allows all of `wish` (n_a) after one that did.
  void follow(const VecA& wish) noexcept { wish_ = used_ = wish; }
  /// The force in use, n_a. `limit`: the force limit, n_a; `tick`, s.
  const VecA& step(const VecA& wish, const VecA& allowed, const VecA& limit, double tick) noexcept;

 private:
  VecA wish_, used_;  ///< of the last tick
  bool whole_{true};
};

}  // namespace haptic::core
