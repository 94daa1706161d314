#pragma once
/// Force control by the server, for a device that does not do it itself: per actuated DoF either a
/// force loop (its output is the drive's force) or an admittance (its output is a position). The
/// reference is tau_a after every limit, the feedback is the force that the device measures.

#include <cstdint>
#include <vector>

#include "haptic/core/control/admittance.hpp"
#include "haptic/core/control/force_loop.hpp"
#include "haptic/core/safety/cell_watch.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

/// One of the first two lists has an entry per actuated DoF, the other is empty; both empty: no
/// force control here.
struct ForceControlSettings {
  std::vector<ForceLoopGains> loops{};
  std::vector<AdmittanceParameters> admittances{};
  std::vector<CellRatings> cells{};  ///< n_a; empty: what is measured is believed

  [[nodiscard]] bool enabled() const noexcept { return !loops.empty() || !admittances.empty(); }
};

/// Limits of the drives of force loops in one step.
struct DriveLimits {
  VecA force{};      ///< N or N m, n_a; size 0: none
  VecA slew{};       ///< N/s or N m/s, n_a
  double gain{1.0};  ///< g of the tick
};

class ForceControl {
 public:
  /// Throws SceneError: a number of entries that is not n_a, or a parameter that is not allowed.
  ForceControl(const ForceControlSettings& settings, int n_a);

  /// The drives are off: forgets the integrals and sets the positions to where the device is. q_a:
  /// n_a.
  void rest(const VecA& q_a) noexcept;
  /// One step of `dt` s (0: as the last one). `measured` empty: the force is not known now; the
  /// reference goes through open loop and nothing is integrated. Never allocates or throws.
  void step(const VecA& reference, const VecA& measured, double dt,
            const DriveLimits& limits = {}) noexcept;

  /// N or N m, n_a: what the drives are to give. Size 0 for an admittance.
  [[nodiscard]] const VecA& drive() const noexcept { return drive_; }
  /// m or rad, n_a: the position that the drives are to reach. Size 0 for a force loop.
  [[nodiscard]] const VecA& position() const noexcept { return position_; }
  /// DoF i was held at a limit of its loop in the last step.
  [[nodiscard]] bool limited(int i) const noexcept { return (limited_ >> i & 1U) != 0; }
  /// The drive of DoF i was held by its slew limit in the last step.
  [[nodiscard]] bool slewed(int i) const noexcept { return (slewed_ >> i & 1U) != 0; }

 private:
  std::vector<ForceLoop> loops_{};
  std::vector<Admittance> admittances_{};
  VecA drive_{};
  VecA position_{};
  std::uint32_t limited_{0};
  std::uint32_t slewed_{0};
};

}  // namespace haptic::core
