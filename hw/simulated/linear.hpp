#pragma once
/// A device with linear dynamics for any map: independent masses on the DoFs,
/// m q_ddot = tau + K_h (target - q) - (b + B_h) q_dot per DoF, in kg and m or kg m^2 and rad.
/// Starts at rest on the target. Ends of a DoF's box are rigid and inelastic. Linearly implicit
/// Euler, so any stiffness is stable.

#include <memory>

#include "hw/bookkeeping.hpp"
#include "hw/device_config.hpp"
#include "hw/simulated/substeps.hpp"

namespace haptic::hw {

/// All of size n_q, except max_effort with n_a; damping, hand and target may be empty: zero. The
/// scene's reader checks sizes and values.
struct SimulatedLinearConfig final : DeviceConfig {
  core::VecQ mass{};
  core::VecQ damping{};
  core::VecQ hand_stiffness{};
  core::VecQ hand_damping{};
  core::VecQ target{};
  core::VecA max_effort{};

  [[nodiscard]] std::unique_ptr<Device> open(std::shared_ptr<const core::Kinematics> kinematics,
                                             core::Duration longest_lateness) const override;
  [[nodiscard]] core::VecA effort() const override { return max_effort; }
  [[nodiscard]] bool is_hardware() const noexcept override { return false; }
  [[nodiscard]] OwnDynamics own_dynamics(const core::DofLayout& layout) const override;
};

class SimulatedLinear final : public Device {
 public:
  /// Throws DeviceError: see device_limits().
  SimulatedLinear(const SimulatedLinearConfig& config,
                  std::shared_ptr<const core::Kinematics> kinematics);

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override;
  void write(core::TimePoint now, const Command& command) noexcept override;
  void close() noexcept override;

  /// The truth at the last whole substep.
  [[nodiscard]] const core::VecQ& q() const noexcept { return q_; }
  [[nodiscard]] const core::VecQ& q_dot() const noexcept { return q_dot_; }

 private:
  void step() noexcept;

  SimulatedLinearConfig config_;
  std::shared_ptr<const core::Kinematics> kinematics_;
  DeviceInfo info_;
  core::VecQ lower_{}, upper_{};
  core::VecQ q_{}, q_dot_{};
  core::VecQ tau_{};  ///< n_q, force acting now
  Substeps substeps_{};
  Bookkeeping book_{};
};

}  // namespace haptic::hw
