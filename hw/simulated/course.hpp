#pragma once
/// Where the simulated user means to go over time in one coordinate: x_des(t) of
/// core/METHOD.md#forces-at-the-finger, a constant or a recording that repeats.

#include <optional>
#include <utility>

#include "hw/motion/pchip.hpp"

namespace haptic::hw {

class Course {
 public:
  /// Rise from the rest pose to the target, or into the recording:
  /// core/METHOD.md#forces-at-the-finger.
  static constexpr double kRise = 0.8;  // s
  /// Way back from the end of a recording to its beginning.
  static constexpr double kReturn = 0.5;  // s

  Course(double rest, double target) noexcept : rest_(rest), target_(target) {}
  Course(double rest, Pchip motion) : rest_(rest), motion_(std::move(motion)) {}

  /// Meaning of `t` seconds after the simulation began, for all courses that play one recording, or
  /// none.
  struct Moment {
    double risen{0.0};     ///< share of the rise
    Pchip::Place place{};  ///< in the recording
    double way_back{0.0};  ///< share of the way from its end to its beginning
  };
  [[nodiscard]] Moment moment(double t) const noexcept;

  /// Continuous. Allocates nothing.
  [[nodiscard]] double at(const Moment& moment) const noexcept;

 private:
  double rest_;
  double target_{0.0};
  std::optional<Pchip> motion_{};
};

}  // namespace haptic::hw
