#pragma once
/// Touch behind a network, judged by its shadow (analysis/shadow_judge.hpp): the shipped pipeline,
/// the shipped client library's contacts, and peers, in virtual time (core/METHOD.md#contacts).

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptic/client/planes.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "tests/report/analysis/shadow_judge.hpp"
#include "tests/report/rtt_object.hpp"
#include "tests/report/sensor_noise.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {

/// Kind of sample that the client sends, and what is done with it.
enum class RttPeer {
  kContacts,   ///< contacts of the client library, near ones too
  kEstimated,  ///< ContactEstimator of the client library: what a session derives from proxies
  kPlanes,     ///< derive_planes() of the client library, while the simulation sees contact
  kHeld,       ///< the proxy; it stays until the next sample
  kHeldForce,  ///< not offered: the last deviation stays, and with it the force; without tank
  kTdpa,       ///< not offered: the same behind time-domain passivity control
};
inline constexpr RttPeer kRttPeers[]{RttPeer::kContacts, RttPeer::kEstimated, RttPeer::kPlanes,
                                     RttPeer::kHeld,     RttPeer::kHeldForce, RttPeer::kTdpa};
[[nodiscard]] inline std::string_view name(RttPeer peer) noexcept {
  return name_in({"contacts", "estimated", "derived_planes", "held", "held_force", "tdpa"}, peer);
}

/// Hand that moves the device, and gives way to its force or does not.
class RttBody {
 public:
  virtual ~RttBody() = default;
  /// Moves on by one tick, to `t` s after the motion began (< 0: before), under the force held.
  virtual void step(double t, const core::VecA& tau) = 0;
  [[nodiscard]] virtual core::VecQ q() const = 0;
};

/// An object, a device, and a motion.
struct RttScene {
  std::string name{};
  RttMaker object{};
  bool one_world{false};  ///< the object is moved by the finger: all look at the same one
  RttMaker own{};         ///< if given, the felt client's simulation has this one instead
  core::PipelineConfig pipeline{};
  double device_damping{0.0};  ///< N s/m, of each actuator
  std::function<std::unique_ptr<RttBody>()> body{};
  double seconds{0.0};                  ///< of the motion
  double most_damping{0.0};             ///< of time-domain passivity control, N s/m
  std::vector<client::Block> blocks{};  ///< for derive_planes()
};

/// Recordings: CSV of joint angles; none: the repository's own grasp.
[[nodiscard]] std::vector<RttScene> rtt_scenes(const std::vector<std::string>& recordings);

struct RttRun {
  RttPeer peer{RttPeer::kContacts};
  double round_trip_s{0.0};
  double rate_hz{60.0};  ///< 1000: every tick, without jitter; else jitter 30 % of the period
  double lost{0.0};
  SensorNoise noise{SensorNoise::kNone};  ///< of what is felt, not of the shadow
};

struct RttTick {
  double t_s{0.0};                ///< since the motion began
  double felt{0.0}, shadow{0.0};  ///< first actuator, N
};

struct RttFigures {
  ShadowFigures shadow{};  ///< of the pipeline without tank and observer
  ShadowFigures bound{};   ///< of the elastic force, against its shadow without any limiter
  double ideal_net{0.0};   ///< J, most_net of the shadow along the same motion
  double most_net{0.0};    ///< J, largest over time that was given beyond the device's damping
  double samples_hz{0.0};  ///< that came
  double band{0.0};        ///< N rms between 50 and 500 Hz, of what is felt less the shadow
  bool ended{false};       ///< force ended before the motion did
};

/// Throws SceneError where the force never came on.
[[nodiscard]] RttFigures run(const RttScene& scene, const RttRun& how,
                             const std::function<void(const RttTick&)>& observe = {});

}  // namespace haptic::report
