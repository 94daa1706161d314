#pragma once
/// A recording as a device: it plays at its original timing, its force is computed and reported,
/// nothing moves.
///
/// A tracked palm's orientation may be recorded as a quaternion, NAME.qx .qy .qz .qw; samples hold
/// it as a rotation vector of length pi at most.
///
/// Joint angles go through the inverse kinematics (see Stretch). Rows outside the reach are
/// replaced at load by the nearest pose in reach, Eq. (6) with the box and the slider limits, and
/// counted. Gaps and the pause between rounds have no samples: reading.fresh is false, nothing else
/// changes.

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "hw/bookkeeping.hpp"
#include "hw/device_config.hpp"
#include "hw/motion/motion_csv.hpp"
#include "hw/replay/stretch.hpp"

namespace haptic::hw {

/// The columns: time_s and the device's DoFs by name (a tracked palm's orientation also as a
/// quaternion), or time_s and each coordinate's name with _rad, which go through the inverse
/// kinematics: time_s,q_o1_mcp_rad,q_o2_pip_rad for a finger.
struct ReplayConfig final : DeviceConfig {
  std::filesystem::path file{};
  bool repeat{false};
  core::VecA max_effort{};  ///< n_a

  [[nodiscard]] std::unique_ptr<Device> open(std::shared_ptr<const core::Kinematics> kinematics,
                                             core::Duration longest_lateness) const override;
  [[nodiscard]] core::VecA effort() const override { return max_effort; }
  [[nodiscard]] bool is_hardware() const noexcept override { return false; }
  [[nodiscard]] std::filesystem::path plays() const override { return file; }
};

/// Properties of the recording, found at loading.
struct ReplayFacts {
  std::size_t rows{0};
  std::size_t gaps{0};       ///< steps of time longer than 50 ms
  std::size_t replaced{0};   ///< rows of joint angles outside the reach
  core::Duration length{0};  ///< first row to last row
  bool joint_angles{false};  ///< else device states
};

class Replay final : public Device {
 public:
  /// Silence between two rounds of a repeated recording, long enough for the force to ramp out
  /// before q jumps back to the beginning.
  static constexpr core::Duration kPause{std::chrono::milliseconds(500)};

  /// Throws DeviceError: see read_motion_csv; also a device state outside its DoF's range (with
  /// margin), joint angles for a kinematics that offers no inverse.
  Replay(const ReplayConfig& config, std::shared_ptr<const core::Kinematics> kinematics);

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override;
  void write(core::TimePoint now, const Command& command) noexcept override;
  void close() noexcept override;

  [[nodiscard]] const ReplayFacts& facts() const noexcept { return facts_; }

 private:
  [[nodiscard]] Columns bring_into_reach(MotionTable& table);
  void cut_at_gaps(const std::vector<double>& time_s, const Columns& q, const Columns& x);
  [[nodiscard]] const Stretch* stretch_at(core::Duration into) const noexcept;

  std::shared_ptr<const core::Kinematics> kinematics_;
  DeviceInfo info_;
  ReplayFacts facts_{};
  std::vector<Stretch> stretches_{};
  bool repeat_{false};
  std::optional<core::TimePoint> start_{};  ///< of the first read()
  core::VecQ q_{};                          ///< newest sample
  core::VecQ home_{};                       ///< zero: rotation vectors are kept near it
  Bookkeeping book_{};
};

}  // namespace haptic::hw
