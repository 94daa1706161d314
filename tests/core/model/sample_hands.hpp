#pragma once
/// Devices that tests and figures are about.

#include <cmath>
#include <vector>

#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/serial_chain.hpp"

namespace haptic::core {

/// A thumb and four fingers of different sizes.
inline const std::vector<HandFinger>& five_fingers() {
  static const std::vector<HandFinger> fingers = {{"thumb", scaled(finger_sign_change(), 0.8)},
                                                  {"index", finger_sign_change()},
                                                  {"middle", scaled(finger_sign_change(), 1.1)},
                                                  {"ring", finger_sign_change()},
                                                  {"little", scaled(finger_sign_change(), 0.75)}};
  return fingers;
}

/// These beside each other across a tracked palm, the thumb turned towards them; a tip and a pad of
/// each, and one output on the palm. `kind`: of tips and palm.
inline TrackedHandParameters five_fingers_on_a_palm(OutputKind kind = OutputKind::kPoint) {
  TrackedHandParameters hand;
  double across = 0.03;
  for (const HandFinger& finger : five_fingers()) {
    const double turn = finger.name == "thumb" ? 0.5 : 0.0;
    hand.fingers.push_back(
        {finger, {{0.09, 0.0, across}, {std::sin(turn), 0.0, 0.0, std::cos(turn)}}});
    across -= 0.02;
    hand.outputs.push_back(
        {finger.name + "_tip", finger.name, Phalanx::kMiddle, kind, {{0.03, -0.008, 0.0}, {}}});
    hand.outputs.push_back({finger.name + "_pad",
                            finger.name,
                            Phalanx::kProximal,
                            OutputKind::kPoint,
                            {{0.025, -0.01, 0.0}, {}}});
  }
  hand.outputs.push_back({"palm", "", Phalanx::kMiddle, kind, {{0.04, -0.02, 0.0}, {}}});
  return hand;
}

/// Three marks on a stylus that are not in a line: its pose in metres alone.
inline std::vector<ChainOutput> marks_on_a_stylus() {
  return {{"tip", "", OutputKind::kPoint, {{0.03, 0, 0}, {}}},
          {"end", "", OutputKind::kPoint, {{-0.10, 0, 0}, {}}},
          {"button", "", OutputKind::kPoint, {{0, 0, 0.03}, {}}}};
}

}  // namespace haptic::core
