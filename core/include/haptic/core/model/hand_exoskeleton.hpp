#pragma once
/// A hand of finger exoskeletons (the paper's section VI, one per finger), in two forms:
///   hand          q = (l_x, q_B) of each finger, x = (MCP, PIP) of each: independent blocks
///   tracked hand  the same on a palm whose pose is tracked: six more sensed, unactuated DoFs, and
///                 x in the world, so that dim X > dim Q and no finger is independent

#include <memory>
#include <string>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/model/rigid_pose.hpp"

namespace haptic::core {

struct HandFinger {
  std::string name{};  ///< "index"
  FingerDimensions dimensions{};
};

/// DoFs NAME.l_x (actuated) and NAME.q_B of each finger in turn; coordinates NAME.q_o1_mcp and
/// NAME.q_o2_pip [rad]. Offers blocks(), one per finger, and the closed-form inverse. Throws
/// SceneError: no finger, more than kMaxQ / 2, a name empty or repeated, or dimensions that cannot
/// be (naming the finger).
[[nodiscard]] std::unique_ptr<Kinematics> make_hand_exoskeleton(
    const std::vector<HandFinger>& fingers);

/// A finger on a tracked palm.
struct MountedFinger {
  HandFinger finger{};
  /// Hand frame of the finger (finger_exoskeleton.hpp: origin on the MCP axis, +x distal, +y
  /// dorsal) in the palm's frame.
  Pose3 mount{};
};

enum class Phalanx : std::uint8_t {
  kProximal,  ///< frame: origin on the MCP axis, +x along the phalanx, +y dorsal
  kMiddle,    ///< frame: origin on the PIP axis, likewise
};

struct PhalanxOutput {
  std::string name{};
  std::string finger{};  ///< by name; empty: the palm itself
  Phalanx phalanx{Phalanx::kMiddle};
  OutputKind kind{OutputKind::kPoint};
  Pose3 offset{};  ///< in the phalanx's (palm's) frame
};

struct TrackedHandParameters {
  TrackedPalm palm{};
  std::vector<MountedFinger> fingers{};
  std::vector<PhalanxOutput> outputs{};  ///< in the order of x
};

/// q: the palm's six DoFs, then NAME.l_x (actuated) and NAME.q_B of each finger. x: OUTPUT.x .y .z
/// [m] and, for frames, OUTPUT.qx .qy .qz .qw, all in the world. Throws SceneError as
/// make_hand_exoskeleton does, and: no output, a name empty or repeated, an unknown finger, more
/// than kMaxQ DoFs or kMaxX coordinates.
[[nodiscard]] std::unique_ptr<Kinematics> make_tracked_hand(
    const TrackedHandParameters& parameters);

}  // namespace haptic::core
