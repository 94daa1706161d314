#pragma once
/// Where the user of a whole hand means to go: the palm's pose and two joint angles per finger, in
/// the order of q, with the joint angles in place of (l_x, q_B).

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/model/kinematics.hpp"
#include "hw/simulated/course.hpp"

namespace haptic::hw {

/// Places of a hand's DoFs in q.
struct HandLayout {
  struct Finger {
    std::string prefix{};   ///< of its names: "index."; empty: a finger alone
    Eigen::Index first{0};  ///< index in q of its l_x; q_B follows
  };
  std::vector<Finger> fingers{};
  /// Index in q of the palm's x; y, z and the rotation vector follow. None: the palm stands still.
  std::optional<Eigen::Index> palm{};
};

class HandIntent {
 public:
  /// From `rest` to `target`, n_q values each, m and rad.
  HandIntent(const core::VecQ& rest, const core::VecQ& target);
  /// The fingers rise to the target from straight, the palm is there.
  HandIntent(const HandLayout& layout, const core::VecQ& target);

  /// Columns of `motion_file`: time_s and any of these, each whole: NAME.q_o1_mcp_rad and
  /// .q_o2_pip_rad of a finger, without NAME if it is alone; PALM.x .y .z; PALM.rx .ry .rz or
  /// PALM.qx .qy .qz .qw. What has no columns stays at the target. Throws DeviceError: see
  /// read_motion_csv(); also no such column at all, or a palm outside its box.
  HandIntent(const HandLayout& layout, const core::VecQ& target, const core::Kinematics& kinematics,
             const std::filesystem::path& motion_file);

  /// The aim `t` s after the simulation began, n_q; continuous. Allocates nothing.
  [[nodiscard]] core::VecQ at(double t) const noexcept;

  /// How many fingers the file moves.
  [[nodiscard]] int recorded_fingers() const noexcept { return recorded_fingers_; }
  /// MotionTable::doubts of the file.
  [[nodiscard]] const std::vector<std::string>& doubts() const noexcept { return doubts_; }

 private:
  std::vector<Course> course_{};
  std::size_t recorded_{0};  ///< a course with the recording, if there is one
  int recorded_fingers_{0};
  std::vector<std::string> doubts_{};
};

}  // namespace haptic::hw
