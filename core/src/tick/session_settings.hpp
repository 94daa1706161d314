#pragma once
/// Stage of a tick: the settings in effect, which are a session's, held within the scene's.

#include <memory>

#include "haptic/core/linear/stiffness_coupling.hpp"
#include "haptic/core/safety/lifecycle.hpp"
#include "haptic/core/tick/tick_input.hpp"

namespace haptic::core {

/// The settings in effect, with the whole stiffness matrix.
struct Settings : RenderSettings {
  MatAA Z_q{};  ///< n_a by n_a, N/m or N m/rad; size 0: diagonal, `stiffness`

  [[nodiscard]] bool coupled() const noexcept { return Z_q.size() > 0; }
  /// Z_q d: the spring's force at gain 1 without any limit, n_a. d: n_a, m or rad.
  [[nodiscard]] VecA unlimited(const VecA& d) const noexcept {
    return coupled() ? VecA(Z_q.lazyProduct(d)) : VecA(stiffness.cwiseProduct(d));
  }
};

class SessionSettings {
 public:
  /// `scene`: the widest settings. `coupling`: that of Z_q; null: it is diagonal.
  SessionSettings(const RenderSettings& scene, std::shared_ptr<const StiffnessCoupling> coupling);

  /// Takes `wanted` over if its id is new: each number only as far as it is tighter than the
  /// scene's. `last`: the device's state of the last tick. Another renderer is another anchor, so
  /// it is not taken over under force. The answer stays valid until the next step.
  [[nodiscard]] const Settings& step(const RenderSettings& wanted, LifecycleState last) noexcept;

 private:
  const RenderSettings scene_;
  const std::shared_ptr<const StiffnessCoupling> coupling_;
  Settings now_{};
};

}  // namespace haptic::core
