#pragma once
/// Judges what a finger feels by the shadow: the force of the same contacts, evaluated without
/// delay on the probe that was really felt. Two runs of one hand, with and without a network, go
/// apart, so a comparison of them says little; the shadow goes where the felt run goes.

#include "haptic/core/types.hpp"

namespace haptic::report {

/// One tick. Forces in N or N m, n_a.
struct ShadowTick {
  core::VecA felt{}, shadow{};
  core::VecA elastic{};   ///< what is felt, but for the damping that the scene renders everywhere
  bool touching{false};   ///< the shadow's probe is beyond a contact
  bool held_back{false};  ///< the energy tank acted on what is felt
  double clearance{0.0};  ///< of the probe from the nearest object, m; < 0: inside
};

struct ShadowFigures {
  double error{0.0};      ///< rms over the ticks in contact of |felt - shadow|
  double largest{0.0};    ///< of the same
  double peak{0.0};       ///< of |shadow|
  double drag{0.0};       ///< largest |elastic| out of contact, farther than kFar from every object
  double held_back{0.0};  ///< share of the ticks in contact
  int contacts{0};        ///< times that contact began
  int onset{0};           ///< most ticks from the shadow's first force to the first felt one
  long ticks{0};          ///< in contact

  /// error in % of the peak; 0 if there was no contact.
  [[nodiscard]] double percent() const noexcept { return peak > 0.0 ? 100.0 * error / peak : 0.0; }
};

class ShadowJudge {
 public:
  static constexpr double kFar = 0.003;  ///< m

  void add(const ShadowTick& tick) noexcept;
  [[nodiscard]] ShadowFigures figures() const noexcept;

 private:
  ShadowFigures sums_{};
  double squares_{0.0};
  long held_back_{0};
  bool touched_{false};  ///< in the tick before
  int late_{-1};  ///< ticks of a contact that is not felt yet; -1: it is felt, or there is none
};

}  // namespace haptic::report
