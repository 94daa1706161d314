#pragma once
/// The ratings of all actuated DoFs of a device, with the temperatures they lead to.

#include <cmath>
#include <cstddef>
#include <vector>

#include "haptic/core/safety/actuator_limits.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

class RatedActuators {
 public:
  /// One entry per actuated DoF, each as check() allows. Allocates; nothing below does.
  explicit RatedActuators(std::vector<ActuatorRatings> ratings)
      : ratings_(std::move(ratings)), states_(ratings_.size()) {
    const auto n_a = static_cast<Eigen::Index>(ratings_.size());
    temperatures_ = VecA::Constant(n_a, std::nan(""));
    bool any = false;
    for (std::size_t i = 0; i < ratings_.size(); ++i) {
      if (!ratings_[i].thermal) continue;
      states_[i] = unknown_history(*ratings_[i].thermal);
      temperatures_[static_cast<Eigen::Index>(i)] = states_[i].winding_c;
      any = true;
    }
    if (!any) temperatures_.resize(0);
  }

  /// The drives gave `force` (n_a) for `dt`.
  void warm(const VecA& force, Duration dt) noexcept {
    for (std::size_t i = 0; i < ratings_.size(); ++i) {
      if (!ratings_[i].thermal) continue;
      const auto a = static_cast<Eigen::Index>(i);
      states_[i] = thermal_step(*ratings_[i].thermal, states_[i], force[a], dt);
      temperatures_[a] = states_[i].winding_c;
    }
  }
  /// The largest force that the temperature of DoF i allows, at most `limit`.
  [[nodiscard]] double force(int i, double limit) const noexcept {
    const auto& rating = ratings_[static_cast<std::size_t>(i)];
    if (!rating.thermal) return limit;
    return thermal_force(*rating.thermal, states_[static_cast<std::size_t>(i)], limit);
  }
  [[nodiscard]] ForceRange moving(int i, double rate, double limit) const noexcept {
    return moving_range(ratings_[static_cast<std::size_t>(i)], rate, limit);
  }
  /// Temperatures of the windings, C, n_a; nan for a DoF without a model; size 0 if no DoF has one.
  [[nodiscard]] const VecA& temperatures() const noexcept { return temperatures_; }

 private:
  std::vector<ActuatorRatings> ratings_;
  std::vector<ThermalState> states_;
  VecA temperatures_{};
};

}  // namespace haptic::core
