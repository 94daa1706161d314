#pragma once
/// The experiment of core/METHOD.md#contacts: masses on rails, one coordinate each, that a hand
/// moves in and out of objects through springs and dampers.

#include <functional>

#include "haptic/core/tick/pipeline.hpp"

namespace haptic::test {

struct Rails {
  static constexpr double coupling = 1500.0;          ///< Z_q, N/m
  static constexpr double mass = 0.3, damping = 2.0;  ///< of a device, kg, N s/m
};

/// A device's mass and damping, and the spring and damper of the hand on it.
struct HandOnMass {
  double mass{Rails::mass}, damping{Rails::damping};  ///< kg, N s/m
  double hand{800.0}, hand_damping{8.0};              ///< N/m, N s/m
};

/// Where a hand aims at, and how fast that moves.
struct HandAim {
  core::VecQ at{}, rate{};
};
using Hand = std::function<HandAim(double t)>;

/// Adds to `aim` a cosine of coordinate i about `centre` from -amplitude on, at rest before t = 0.
void swing(double t, double hz, double centre, double amplitude, Eigen::Index i, HandAim& aim);
/// One coordinate about 0.
[[nodiscard]] Hand swinging(double hz, double amplitude);

/// The masses; the device's own damping is implicit and never gives energy.
class HandMasses {
 public:
  /// At rest where the hand is before its motion.
  explicit HandMasses(Hand hand, const HandOnMass& of = {});

  /// Over one tick of 1 ms that ends at `t` s, under the force held.
  void step(double t, const core::VecA& tau);
  [[nodiscard]] const core::VecQ& q() const noexcept { return q_; }  ///< m
  [[nodiscard]] const core::VecQ& v() const noexcept { return v_; }  ///< m/s

 private:
  Hand hand_;
  HandOnMass of_;
  core::VecQ q_, v_;
};

/// Pipeline of n rails, without a tank.
[[nodiscard]] core::PipelineConfig rails(int n);
/// A rail whose proxy is held for 400 ms and gone after 500 ms, however late samples come. `tank`:
/// tank_0, J; below 0: no tank.
[[nodiscard]] core::PipelineConfig patient_rail(double tank = -1.0);

}  // namespace haptic::test
