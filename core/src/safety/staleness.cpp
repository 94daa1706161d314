#include "haptic/core/safety/staleness.hpp"

#include <algorithm>

#include "haptic/core/names.hpp"

namespace haptic::core {

using std::chrono::milliseconds;

std::string_view name(Staleness level) noexcept {
  static constexpr std::array<std::string_view, 5> kNames{"UNKNOWN", "FRESH", "HOLD", "FADE",
                                                          "LOST"};
  return name_of(level, kNames);
}

Staleness staleness(Duration age, Duration valid_for, const StalenessLimits& limits) noexcept {
  const Duration fresh_end =
      valid_for > Duration::zero() ? std::min(valid_for, limits.fresh_end) : limits.fresh_end;
  if (age < fresh_end) return Staleness::kFresh;
  if (age < limits.hold_end) return Staleness::kHold;
  if (age < limits.fade_end) return Staleness::kFade;
  return Staleness::kLost;
}

double ladder(Duration age, const StalenessLimits& limits) noexcept {
  if (age < limits.hold_end) return 1.0;
  if (age >= limits.fade_end) return 0.0;
  return static_cast<double>((limits.fade_end - age).count()) /
         static_cast<double>((limits.fade_end - limits.hold_end).count());
}

Duration default_fresh_end(double rate_hz) noexcept {
  constexpr double kPeriods = 2.5;
  constexpr double kShortest = 5e6, kLongest = 80e6;  // ns
  return Duration(
      static_cast<Duration::rep>(std::clamp(kPeriods * 1e9 / rate_hz, kShortest, kLongest)));
}

const char* check(const StalenessLimits& limits) noexcept {
  if (limits.fresh_end <= Duration::zero()) return "fresh_end must be > 0";
  if (limits.fresh_end > limits.hold_end) return "fresh_end must be <= hold_end";
  if (limits.fade_end - limits.hold_end < milliseconds(50)) {
    return "fade_end - hold_end must be >= 50 ms";
  }
  return nullptr;
}

StalenessLimits tightened(const StalenessLimits& wanted, const StalenessLimits& scene) noexcept {
  StalenessLimits limits = check(wanted) == nullptr ? wanted : scene;
  limits.hold_end = std::min(limits.hold_end, scene.hold_end);
  limits.fade_end = std::min(limits.fade_end, scene.fade_end);
  return limits;
}

}  // namespace haptic::core
