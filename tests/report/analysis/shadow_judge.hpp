#pragma once
/// Judges what a finger feels by the shadow: the force of the same contacts, evaluated without
/// delay on the probe that was really felt. Two runs of one hand, with and without a network, go
/// apart, so a comparison of them says little; the shadow goes where the felt run goes.

#include <vector>

#include "haptic/core/types.hpp"

namespace haptic::report {

/// One tick. Forces in N or N m, n_a.
struct ShadowTick {
  core::VecA felt{}, shadow{};
  core::VecA elastic{};   ///< what is felt, but for the damping that the scene renders everywhere
  bool touching{false};   ///< the shadow's probe is beyond a contact
  bool held_back{false};  ///< the energy tank acted on what is felt
  double clearance{0.0};  ///< of the probe from the nearest object, m; < 0: inside
  core::VecA bound{};     ///< published, of what is felt against the shadow; size 0: none
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
  double bounded{0.0};    ///< share of the ticks in contact that have a bound
  double kept{1.0};       ///< share of all ticks with a bound in which it holds
  double error_median{0.0}, bound_median{0.0};  ///< over the ticks in contact that have a bound

  /// error in % of the peak; 0 if there was no contact.
  [[nodiscard]] double percent() const noexcept { return peak > 0.0 ? 100.0 * error / peak : 0.0; }
};

class ShadowJudge {
 public:
  static constexpr double kFar = 0.003;      ///< m
  static constexpr double kRounding = 1e-5;  ///< N or N m, of two solutions of one problem

  void add(const ShadowTick& tick);
  [[nodiscard]] ShadowFigures figures() const;

 private:
  ShadowFigures sums_{};
  double squares_{0.0};
  long held_back_{0};
  long bounds_{0}, broken_{0};                 ///< ticks, of all
  std::vector<double> errors_{}, promised_{};  ///< in contact, with a bound
  bool touched_{false};                        ///< in the tick before
  int late_{-1};  ///< ticks of a contact that is not felt yet; -1: it is felt, or there is none
};

}  // namespace haptic::report
