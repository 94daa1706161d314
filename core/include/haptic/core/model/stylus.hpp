#pragma once
/// A desk stylus held like a pen: six sensed joints, the first three actuated (turntable, shoulder,
/// elbow), three gimbal joints that are only read: the pose of the stylus is known, but only three
/// directions of it can be pushed. World frame: origin where the turntable's axis meets the
/// shoulder's, +x away from the base, +y to the left, +z up.

#include <vector>

#include "haptic/core/model/serial_chain.hpp"

namespace haptic::core {

/// Lengths in m, angles in rad. Defaults: our choice, the reach of a small desktop device. Joints
/// are positive to the left, upwards, and clockwise seen along the stylus; at zero, which is
/// outside of the elbow's box, arm and stylus lie stretched along +x.
struct StylusDimensions {
  double upper_arm{0.13};  ///< shoulder to elbow
  double forearm{0.13};    ///< elbow to the gimbal's centre, where its three axes meet
  double tip{0.03};        ///< from the gimbal's centre to the tip, along the stylus
  double turntable_lower{-0.9}, turntable_upper{0.9};
  double shoulder_lower{-0.3}, shoulder_upper{1.5};
  double elbow_lower{-2.4}, elbow_upper{-0.4};   ///< 0 and -pi would be singular
  double gimbal_lower{-1.2}, gimbal_upper{1.2};  ///< yaw and pitch; pitch +-pi/2 would be singular
  double roll_lower{-2.6}, roll_upper{2.6};
};

/// The joints turntable, shoulder, elbow, gimbal_yaw, gimbal_pitch, gimbal_roll; no output. Throws
/// SceneError: a length that is not finite and > 0.
[[nodiscard]] SerialChainParameters stylus_chain(const StylusDimensions& dimensions);

/// X from `outputs`, whose links are the joints' names; empty: the frame of the tip, "tip". Throws
/// SceneError as stylus_chain and make_serial_chain do.
[[nodiscard]] std::unique_ptr<Kinematics> make_stylus(const StylusDimensions& dimensions,
                                                      std::vector<ChainOutput> outputs = {});

}  // namespace haptic::core
