#pragma once
/// Doubts about the load cell of one actuated DoF, on which the server closes a force loop or an
/// admittance: core/METHOD.md#a-load-cell-that-lies, Eq. (29) and (30). A cell that is believed and
/// wrong turns the loop against the finger, so a reading that cannot be true is a fault.
///
/// One step per tick, on the server's clock; it allocates nothing and never throws.

#include <limits>
#include <optional>

#include "haptic/core/fault.hpp"

namespace haptic::core {

/// Bounds that every true reading keeps. A bound that is left infinite is not watched.
struct CellRatings {
  double range{std::numeric_limits<double>::infinity()};  ///< N or N m, > 0: |reading|
  double rate{std::numeric_limits<double>::infinity()};   ///< N/s or N m/s, > 0: of its growth
  /// The command may move so far, > 0, while the cell gives the very same reading: N or N m of a
  /// force loop, m or rad of an admittance.
  double swing{std::numeric_limits<double>::infinity()};
  /// F_s, N or N m, > 0: |drive - reading| of a drive that stands still. Infinite for an
  /// admittance: the force of its drive is not known.
  double friction{std::numeric_limits<double>::infinity()};
  /// D, N s/m or N m s/rad, >= 0: the most by which the drive brakes itself. Absent: the device's
  /// (DeviceLimits::drive_damping), or 0 if that is not known.
  std::optional<double> damping{};
};

/// nullptr if the ratings are consistent; else what is wrong.
[[nodiscard]] const char* check(const CellRatings& ratings) noexcept;

/// One tick as the watch sees it.
struct CellView {
  double reading{0.0};   ///< newest of the cell, N or N m
  bool fresh{false};     ///< it came in this tick
  double interval{0.0};  ///< s since the reading before was measured, if fresh; > 0
  bool driven{false};    ///< the drive followed `command` since the last tick
  double command{0.0};   ///< N or N m of a force loop, m or rad of an admittance
  double q{0.0};         ///< of the DoF, m or rad
  bool at_lower{false};  ///< the drive may be stopped by the lower end of its own travel
  bool at_upper{false};
  double dt{0.0};  ///< s since the last tick, >= 0
};

class CellWatch {
 public:
  static constexpr double kTime{0.1};  ///< s, of the averages of Eq. (30)
  static constexpr int kSame{50};      ///< equal readings in a row that noise does not give

  /// `ratings` as check() allows.
  explicit CellWatch(const CellRatings& ratings) noexcept : ratings_(ratings) {}

  /// The doubts of this tick; none of them lasts by itself. The range is watched always, the rest
  /// while the drive is on: a device that is put down hard is no fault. A number that is not finite
  /// is doubted.
  [[nodiscard]] FaultSet step(const CellView& view) noexcept;

 private:
  [[nodiscard]] bool too_fast(const CellView& view) const noexcept;
  [[nodiscard]] bool stuck(const CellView& view) noexcept;
  [[nodiscard]] bool disagrees(const CellView& view) noexcept;

  CellRatings ratings_;
  std::optional<double> last_{};  ///< reading
  double began_at_{0.0};          ///< command when the reading last changed, or the drive went on
  int same_{0};                   ///< equal readings since the command moved by `swing` from there
  double excess_{0.0};            ///< average of command - reading, N or N m
  double followed_{0.0};          ///< average of q
};

}  // namespace haptic::core
