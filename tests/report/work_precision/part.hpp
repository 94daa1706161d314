#pragma once
/// Speed and error of the parts of a tick that are not a way to q*: each against an independent
/// answer that is slower or less simple.

#include <functional>
#include <string>
#include <vector>

namespace haptic::report {

/// Ours and the one it is compared with; a run is `calls` calls.
struct PartFigure {
  std::string map{}, setting{}, method{}, against{};
  std::function<void()> ours{}, theirs{};
  int calls{1};
  double error_max{0.0}, error_rms{0.0};
  std::string error_unit{};
};

/// Planes by active set against every subset of them (core/METHOD.md#local-models), 1, 3 and 6
/// planes.
[[nodiscard]] std::vector<PartFigure> plane_figures();
/// The monotone envelope of Eq. (6) with its few points against 400 of the closed form
/// (core/METHOD.md#forces-at-the-finger).
[[nodiscard]] std::vector<PartFigure> envelope_figures();
/// What the tank's booking adds to a tick under Eq. (1) and (4): how stiff its spring is, by the
/// trace, against the largest eigenvalue (core/METHOD.md#energy-tank); finger, and hand of five.
[[nodiscard]] std::vector<PartFigure> tank_figures();
/// The chord of a rotation that X uses and the chord 2 sin(theta/2)
/// (core/METHOD.md#metric-and-limits), against the logarithm: error is what they are short of the angle, relative.
[[nodiscard]] std::vector<PartFigure> rotation_figures();

}  // namespace haptic::report
