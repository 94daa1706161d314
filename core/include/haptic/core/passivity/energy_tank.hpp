#pragma once
/// The energy tank (core/METHOD.md#energy-tank): the force may give only as much energy as the tank
/// holds. A spring that stores more than that is lent as long as its force keeps within what is
/// left in the next hold, even if the hand lets go. The force fades so early that what is left pays
/// for letting it go slowly (ForceFade), and is whole again when the user has put in enough. It
/// reckons with V(q_a) and with the force that was held over each tick, so that for every client,
/// renderer, rate and delay
///   energy given to the user, net of the device's own damping
///     <= initial + integral P_env dt + debt.
/// The level falls below 0 only by what the tank cannot refuse. That is the leak of the hold on a
/// device whose damping is unknown or too small (K T/2 > b, core/METHOD.md#sampled-data), and a
/// limited or late force. While a spring is lent, it is also the surprise of a device that
/// something else pushes along the force (Motion::share()). The spring then pays at once, out of
/// what it stores; debt is what the whole spring could not pay. If the tank only refused further
/// changes and kept the spring, a stiff spring would give out 100 times as much energy (measured).

#include "haptic/core/passivity/force_fade.hpp"
#include "haptic/core/passivity/spring_storage.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

struct TankSettings {
  bool enabled{false};        ///< off: no change is ever held back
  double initial{0.0};        ///< tank_0, J, at every Engage; 0 = strictly passive
  double capacity{0.05};      ///< tank_max, J, > 0: a cap, so that energy saved long ago cannot
                              ///< pay for a later burst
  double allowed_power{0.0};  ///< P_env, W: what a moving environment may put in; 0 = nothing
};

/// Energies of the last hold, J: the force was constant while q_a moved by dq
/// (core/METHOD.md#energy-tank).
struct HoldAccount {
  double leak{0.0};      ///< of the hold: V after - V before + tau^T dq >= 0, tau = the spring's
                         ///< force before limits
  double limits{0.0};    ///< taken from the user by slew and other limits; of either sign
  double rendered{0.0};  ///< taken by rendered damping and the controller; of either sign
  double device_damping{0.0};  ///< least that the device's own damping took, b_dev |dq|^2 / T
};

/// How the device moved, and what moved it: what the next hold can give at most follows from it.
struct Motion {
  VecA dq{};         ///< of the last hold, n_a; m or rad
  VecA more{};       ///< dq less that of the hold before, n_a
  VecA held{};       ///< force of the last hold, n_a
  VecA kick{};       ///< T^2 / (2 M_a): how far a unit of force moves M_a in a hold, from rest, n_a
  VecA slew{};       ///< by which a force can fall from hold to hold, n_a; size 0: at once
  VecA drift{};      ///< rate, m/s or rad/s, mean of about kDrift_s, n_a
  VecA jitter{};     ///< mean of |more| over about kJitter_s, n_a; size 0: none
  VecA limit{};      ///< force limit, n_a: how slowly a force fades (ForceFade)
  double tick{0.0};  ///< s

  static constexpr double kDrift_s = 0.01, kJitter_s = 0.05;

  /// The largest share, 0 to 1, of a force tau (n_a) that gives no more than `left` (J, > 0) in the
  /// next hold and in those in which it then falls by `slew`. In these it makes the device faster
  /// too, if nothing else pushes the device along it: a hand may let go with any sample.
  /// `slowly`: of what a slow end of tau leaves (ForceFade), if dq is as noisy as it was.
  [[nodiscard]] double share(const VecA& tau, double left, bool slowly = false) const noexcept;

 private:
  /// J that tau gives while it fades (ForceFade), if the device goes on twice as fast as it drifts.
  [[nodiscard]] double fading(const VecA& tau) const noexcept;
};

class EnergyTank {
 public:
  /// J: a smaller rise is taken for rounding. The anchor of a finger at rest is recomputed in every
  /// tick, and must not look like a change that an empty tank cannot pay.
  static constexpr double kRounding = 1e-12;

  explicit EnergyTank(const TankSettings& settings) : settings_(settings) { restart(); }

  /// At an Engage: the level is `initial`, every debt is forgiven.
  void restart() noexcept {
    level_ = settings_.initial;
    contacts_ = 0.0;
    fade_.restart();
  }
  /// Once per tick: adds P_env dt and what limits and rendered damping took from the user, and
  /// subtracts the hold's leak as far as the device's damping does not pay it. `dt` in s.
  void refill(double dt, const HoldAccount& account) noexcept;

  /// The spring changes while q_a stays: from the stored energy `before` (J) to the spring `after`
  /// at deviation d (n_a). Pays for the rise and returns s in [0, 1]: s d is the deviation that may
  /// be used. A rise of gain or stiffness that cannot be paid shortens the spring like any other
  /// change. `motion`: what the next hold can give is judged by it; null: nothing is lent.
  /// `contacts`: what the contacts behind the spring store, J. Up to so much of what the spring
  /// leaves is theirs: it was put in, it comes back when they recover, and the capacity does not
  /// cut it (core/METHOD.md#contacts). A value that is too large only saves more.
  [[nodiscard]] double admit(double before, const SpringStorage& after, const VecA& d,
                             const Motion* motion = nullptr, double contacts = 0.0) noexcept;

  /// J; negative after admit(): lent to the spring, or, if the spring is gone, debt.
  [[nodiscard]] double level() const noexcept { return level_; }
  /// J, >= 0: what the contacts hold, besides the level.
  [[nodiscard]] double contacts() const noexcept { return contacts_; }

 private:
  void keep(double left, double contacts) noexcept;
  /// The share of d in use if `paid` may be stored and V(d) is not there, or was not.
  [[nodiscard]] double eased(double left, double paid, const SpringStorage& after, const VecA& d,
                             const Motion& motion) noexcept;

  TankSettings settings_;
  ForceFade fade_{};
  double level_{0.0};
  double contacts_{0.0};
};

}  // namespace haptic::core
