#pragma once
/// One tick as a pure function of its input: rows 3 to 10 of core/README.md#one-tick, and the only
/// place where core's parts are put together. It owns every temporary, and the device's state and
/// gain.

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "haptic/core/control/force_control.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/passivity/passivity.hpp"
#include "haptic/core/rendering/projection_model.hpp"
#include "haptic/core/safety/actuator_limits.hpp"
#include "haptic/core/safety/late_bucket.hpp"
#include "haptic/core/tick/tick_input.hpp"
#include "haptic/core/tick/tick_record.hpp"

namespace haptic::core {

/// The consequence if the device gives no sample for longer than its max_silence.
enum class SilencePolicy : std::uint8_t {
  kFault,    ///< hardware: fault DEVICE_SILENT
  kRampOut,  ///< a recording's gap: g falls, and ramps back when samples return
};

struct DeviceLimits {
  Duration sample_period{std::chrono::milliseconds(1)};  ///< nominal
  Duration max_silence{std::chrono::milliseconds(10)};
  SilencePolicy silence_policy{SilencePolicy::kFault};
  VecQ q_lower{}, q_upper{};  ///< range beyond which a sample is a fault (margin included)
  VecA max_effort{};          ///< n_a, N or N m: what the device's spec sheet allows
  /// n_a, N s/m or N m s/rad: the most by which a drive brakes itself; size 0: not known.
  VecA drive_damping{};
};

/// Low-passes against the noise of the sensors (core/METHOD.md#noise-of-the-sensors).
struct SensorFilter {
  /// Lag of the DoFs that are only sensed, at most: with derating, what the stiffness allows.
  Duration sensed_lag{0};
  Duration rate_lag{0};      ///< of the rate of the actuated ones
  Duration actuated_lag{0};  ///< of the actuated ones, likewise; all 0: none

  [[nodiscard]] double longest_s() const noexcept {
    return seconds(std::max(sensed_lag, actuated_lag));
  }
};
/// A scene that names none gets these.
inline constexpr SensorFilter kDefaultFilter{
    std::chrono::milliseconds(3), std::chrono::milliseconds(2), std::chrono::milliseconds(1)};

/// A client says where the tracked palm is (proto/README.md#a-session, role tracker).
struct TrackerSettings {
  int first_dof{0};             ///< of the palm's six in q
  StalenessLimits staleness{};  ///< of its pose, by the same rules as the proxy's
};

struct PipelineConfig {
  std::shared_ptr<const Kinematics> kinematics{};
  ProjectionSettings projection{};  ///< metric W_x, and the prior if the map needs one
  DeviceLimits device{};
  SensorFilter filter{};
  RenderSettings scene{};  ///< the widest settings; a session's are held within these
  Duration loop_late_fault{std::chrono::milliseconds(20)};
  int late_bucket_full{LateBucket::kFull};
  PassivitySettings passivity{};  ///< energy tank and observer; off by default
  /// Lowers the stiffness to what the loop allows as it is measured, if passivity.device_damping is
  /// known and above 0 (core/METHOD.md#stiffness-in-effect).
  bool derating{false};
  std::vector<ActuatorRatings> ratings{};    ///< n_a, or none: power, rate and temperature
  ForceControlSettings force_control{};      ///< by the server; off by default
  std::optional<TrackerSettings> tracker{};  ///< absent: the device senses all of q
};

class Pipeline {
 public:
  /// Throws SceneError if sizes or limits do not fit together, and if x does not determine q
  /// and no prior is given (require_rank: core/METHOD.md#hand-without-prior).
  explicit Pipeline(PipelineConfig config);
  ~Pipeline();
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;

  /// `newest`: sample of the proxy. Allocates nothing, locks nothing, logs nothing, throws nothing,
  /// reads no clock. From the same initial state the same inputs give the same bits.
  [[nodiscard]] TickRecord tick(const TickInput& input, const ProxySnapshot& newest) noexcept;

  [[nodiscard]] const PipelineConfig& config() const noexcept;

 private:
  class Stages;
  std::unique_ptr<Stages> stages_;
};

}  // namespace haptic::core
