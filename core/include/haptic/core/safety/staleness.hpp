#pragma once
/// Age of the newest proxy -> level and ladder (proto/README.md#staleness-and-gain). Intervals are
/// half-open.

#include <cstdint>
#include <string_view>

#include "haptic/core/time.hpp"

namespace haptic::core {

enum class Staleness : std::uint8_t {
  kFresh = 1,  ///< age < fresh_end: moved by its local model
  kHold = 2,   ///< age < hold_end: frozen, full stiffness
  kFade = 3,   ///< age < fade_end: frozen, ladder falls linearly 1 -> 0
  kLost = 4,   ///< beyond, or no proxy at all: no elastic force
};

[[nodiscard]] std::string_view name(Staleness level) noexcept;  ///< "FRESH", ...

struct StalenessLimits {
  Duration fresh_end{std::chrono::milliseconds(20)};
  Duration hold_end{std::chrono::milliseconds(100)};
  Duration fade_end{std::chrono::milliseconds(180)};

  friend bool operator==(const StalenessLimits&, const StalenessLimits&) = default;
};

/// fresh_end = min(valid_for, limits.fresh_end); valid_for <= 0 means the sample gave none.
[[nodiscard]] Staleness staleness(Duration age, Duration valid_for,
                                  const StalenessLimits& limits) noexcept;
/// 1 below hold_end, linear to 0 at fade_end.
[[nodiscard]] double ladder(Duration age, const StalenessLimits& limits) noexcept;
/// 2.5 nominal periods of a client of this rate, clamped to 5..80 ms
/// (proto/README.md#staleness-and-gain). rate_hz > 0.
[[nodiscard]] Duration default_fresh_end(double rate_hz) noexcept;
/// nullptr if the limits hold together (0 < fresh_end <= hold_end, fade_end - hold_end >= 50
/// ms); else what is wrong, to be shown with the values.
[[nodiscard]] const char* check(const StalenessLimits& limits) noexcept;
/// Limits that a session wants (if they hold together, else the scene's), with hold_end and
/// fade_end no later than the scene's.
[[nodiscard]] StalenessLimits tightened(const StalenessLimits& wanted,
                                        const StalenessLimits& scene) noexcept;

}  // namespace haptic::core
