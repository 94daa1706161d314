#pragma once
/// A finger, or a hand that wears an exoskeleton on every finger, as a device, for
/// finger_exoskeleton, hand_exoskeleton and tracked_hand: the physics of
/// core/METHOD.md#forces-at-the-finger per finger behind sensors with noise and resolution, and
/// under a tracked hand a palm that the user's arm moves. Its time is that of the calls, real or
/// virtual. The same seed and the same calls give the same bits.
///
/// The exoskeleton stands on the hand and not on the ground. Its actuators push between palm and
/// finger, so no wrench of theirs is left over for the arm. The fingers give way but the palm does
/// not (core/METHOD.md#forces-at-the-finger: what is left out, and its size).
///
/// The forces of the last write() act until the next one, as long as the device is armed. DISARMED,
/// ARMING and ARMED as in hw/device.hpp; LOST only by close().

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "hw/bookkeeping.hpp"
#include "hw/device_config.hpp"
#include "hw/simulated/hand_intent.hpp"
#include "hw/simulated/palm_physics.hpp"
#include "hw/simulated/substeps.hpp"
#include "hw/simulated/worn_finger.hpp"

namespace haptic::hw {

struct SimulatedHandConfig final : DeviceConfig, WornFinger {
  int fingers{1};  ///< of the kinematics
  std::uint64_t seed{1};
  std::filesystem::path motion_file{};  ///< empty: `target` alone
  /// n_q: the palm's pose (m, rotation vector in rad), then MCP and PIP of each finger (rad). Size
  /// 0: zeros.
  core::VecQ target{};
  ArmParameters arm{};

  [[nodiscard]] std::unique_ptr<Device> open(std::shared_ptr<const core::Kinematics> kinematics,
                                             core::Duration longest_lateness) const override;
  [[nodiscard]] core::VecA effort() const override;
  [[nodiscard]] bool is_hardware() const noexcept override { return false; }
  [[nodiscard]] std::filesystem::path plays() const override { return motion_file; }
  [[nodiscard]] OwnDynamics own_dynamics(const core::DofLayout& layout) const override;
};

class SimulatedHand final : public Device {
 public:
  /// The step of a hand. It is twice that of a finger without a palm, Substeps::kStep, because
  /// five fingers share a tick.
  static constexpr core::Duration kStep{std::chrono::microseconds(200)};

  /// Throws DeviceError: a motion file that cannot be read (see HandIntent), a kinematics that is
  /// not a finger's or a hand's, a config for another number of fingers or DoFs. The scene's reader
  /// checks the parameters.
  SimulatedHand(const SimulatedHandConfig& config,
                std::shared_ptr<const core::Kinematics> kinematics);

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override;
  void write(core::TimePoint now, const Command& command) noexcept override;
  void close() noexcept override;

  /// The state without the errors of the sensors, in the order of the fingers in q.
  [[nodiscard]] const std::vector<FingerPhysics>& fingers() const noexcept { return fingers_; }
  /// None on a hand_exoskeleton.
  [[nodiscard]] const std::optional<PalmPhysics>& palm() const noexcept { return palm_; }
  [[nodiscard]] const HandIntent& intent() const noexcept { return intent_; }
  /// Forces acting now, N: 0 unless armed, within the limit.
  [[nodiscard]] const core::VecA& tau_a() const noexcept { return tau_a_; }

 private:
  void step() noexcept;
  [[nodiscard]] PalmPose aimed_palm() const noexcept;

  SimulatedHandConfig config_;
  HandLayout layout_;
  DeviceInfo info_;
  HandIntent intent_;
  std::vector<FingerPhysics> fingers_{};
  std::optional<PalmPhysics> palm_{};
  Gaussian noise_;
  core::Duration step_;
  Substeps substeps_{step_};
  std::int64_t steps_{0};
  Bookkeeping book_{};
  core::VecA tau_a_{};
  core::VecQ aim_;  ///< of the step
};

}  // namespace haptic::hw
