#pragma once
/// The finger exoskeleton worn on a simulated finger, as a device: the physics of
/// core/METHOD.md#forces-at-the-finger behind sensors with noise and resolution. Its time is that
/// of the calls, real or virtual. The same seed and the same calls give the same bits.
///
/// The force of the last write() acts until the next one (zero-order hold), as long as the device
/// is armed. DISARMED, ARMING and ARMED as in hw/device.hpp; LOST only by close().

#include <cstdint>
#include <filesystem>
#include <memory>

#include "hw/bookkeeping.hpp"
#include "hw/device_config.hpp"
#include "hw/random.hpp"
#include "hw/simulated/finger_physics.hpp"
#include "hw/simulated/intent.hpp"
#include "hw/simulated/substeps.hpp"
#include "hw/simulated/worn_finger.hpp"

namespace haptic::hw {

struct SimulatedFingerConfig final : DeviceConfig, WornFinger {
  std::uint64_t seed{1};
  std::filesystem::path motion_file{};  ///< joint angles the user aims at; empty: `target`
  double target_mcp{0.0};               ///< rad
  double target_pip{0.0};

  [[nodiscard]] std::unique_ptr<Device> open(std::shared_ptr<const core::Kinematics> kinematics,
                                             core::Duration longest_lateness) const override;
  [[nodiscard]] core::VecA effort() const override;
  [[nodiscard]] bool is_hardware() const noexcept override { return false; }
  [[nodiscard]] std::filesystem::path plays() const override { return motion_file; }
  [[nodiscard]] OwnDynamics own_dynamics(const core::DofLayout& layout) const override;
};

class SimulatedFinger final : public Device {
 public:
  /// Throws DeviceError: a motion file that cannot be read, a kinematics that is not
  /// finger_exoskeleton. The scene's reader checks the parameters.
  SimulatedFinger(const SimulatedFingerConfig& config,
                  const std::shared_ptr<const core::Kinematics>& kinematics);

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override;
  void write(core::TimePoint now, const Command& command) noexcept override;
  void close() noexcept override;

  /// The state without the errors of the sensors.
  [[nodiscard]] const FingerPhysics& physics() const noexcept { return physics_; }
  /// Force acting now, N: 0 unless armed, within the limit.
  [[nodiscard]] double tau_a() const noexcept { return tau_a_; }

 private:
  SimulatedFingerConfig config_;
  DeviceInfo info_;
  Intent intent_;
  FingerPhysics physics_;
  Gaussian noise_;
  Substeps substeps_{};
  std::int64_t steps_{0};
  Bookkeeping book_{};
  double tau_a_{0.0};
};

}  // namespace haptic::hw
