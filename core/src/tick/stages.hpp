#pragma once
/// The stages of one tick, in reading order, with every temporary as a member. Private to the
/// pipeline.

#include <optional>

#include "haptic/core/control/force_control.hpp"
#include "haptic/core/control/impedance.hpp"
#include "haptic/core/passivity/passivity.hpp"
#include "haptic/core/projection/block_map.hpp"
#include "haptic/core/projection/block_renderer.hpp"
#include "haptic/core/projection/direction_guard.hpp"
#include "haptic/core/projection/linear_certificate.hpp"
#include "haptic/core/projection/local_proxy.hpp"
#include "haptic/core/projection/monotone_envelope.hpp"
#include "haptic/core/safety/actuator_ratings.hpp"
#include "haptic/core/safety/device_state.hpp"
#include "haptic/core/safety/late_bucket.hpp"
#include "haptic/core/safety/limits.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "palm_tracker.hpp"

namespace haptic::core {

class Pipeline::Stages {
 public:
  explicit Stages(PipelineConfig config);

  [[nodiscard]] TickRecord tick(const TickInput& input) noexcept;
  [[nodiscard]] const PipelineConfig& config() const noexcept { return config_; }

 private:
  /// dt, and what the loop says of itself.
  void begin(const TickInput& input, TickRecord& record) noexcept;
  /// A session's settings, held within the scene's.
  void settings(const RenderSettings& wanted) noexcept;
  /// The device's sample, with the tracker's pose where a client says the palm's; valid for one
  /// tick.
  [[nodiscard]] const VecQ& sensed(const VecQ& q) noexcept;
  /// Step 3: the newest sample in q, or the fault that it is.
  void device(const TickInput& input, TickRecord& record) noexcept;
  /// Step 4, first half: age of the proxy, level and ladder.
  void proxy(const TickInput& input, TickRecord& record) noexcept;
  /// Steps 5-7: kinematics, proxy at `now`, subspace proxy.
  void projection(TickRecord& record) noexcept;
  /// The blocks that nothing can hold in this tick: their f is not asked for, dx = 0, q* = q.
  [[nodiscard]] BlockSet blocks_left_out() noexcept;
  /// x_probe and the proxy `x` into the record, nan where the tick does not know them.
  void tell_proxy(const VecX& x, TickRecord& record) const noexcept;
  /// Of the blocks that the proxy displaces, whose J this tick reads.
  [[nodiscard]] BlockSet needs_J() const noexcept;
  void keep_last_anchor() noexcept;
  /// The certificate of core/METHOD.md#exact-derivatives for the projection of this tick.
  void certify(TickRecord& record) noexcept;
  /// Requests of people: stop, clear, release, engage.
  void requests(const TickInput& input, TickRecord& record) noexcept;
  [[nodiscard]] EngageAnswer judge_engage(const TickInput& input,
                                          const TickRecord& record) noexcept;
  /// Step 4, second half: the state and its gain.
  void state(const TickInput& input, TickRecord& record) noexcept;
  /// Step 7, last part: envelope or direction guard. True where the elastic force is withheld.
  [[nodiscard]] bool withheld(TickRecord& record) noexcept;
  /// How stiff the tank's spring is: as much as can be felt, but at least Z_q and no more than the
  /// device's own damping pays the hold's leak of.
  void displayed() noexcept;
  /// Z_q S dq of this tick, Eq. (6), (7), without the gain; where Z_q is coupled saturated as a
  /// whole.
  [[nodiscard]] VecA spring_force() const noexcept;
  /// How far a coupled spring may be stretched in this tick, by what its actuators may give in it.
  void hold_within_limits() noexcept;
  void report_saturation(TickRecord& record) noexcept;
  /// Steps 7 and 9: the tank decides the anchor in use, the observer what it adds to the damping.
  void passivity(TickRecord& record, bool spring_is_off) noexcept;
  /// Steps 8-10: force, and its limits.
  void force(TickRecord& record) noexcept;
  void limited_force(int i, double elastic, double damping, TickRecord& record) noexcept;
  void no_output(TickRecord& record) noexcept;
  /// Step 11: the force loop or the admittance, where the scene has one.
  void drive(TickRecord& record, bool powered) noexcept;

  /// The measured force of a sample: none (unless force control needs it), or n_a finite numbers.
  [[nodiscard]] bool force_fits(const VecA& force) const noexcept;
  /// A held or planes sample of the right sizes, every number finite.
  [[nodiscard]] bool fits_space(const ProxySnapshot& sample) const noexcept;
  [[nodiscard]] bool device_sample_is_recent(TimePoint now) const noexcept;
  [[nodiscard]] bool silent_too_long(TimePoint now) const noexcept;

  PipelineConfig config_;
  const Kinematics& kinematics_;
  const DofLayout layout_;
  const ProjectionModel model_;

  RenderSettings settings_;
  BlockMap map_;           ///< x_probe and J
  const bool leaves_out_;  ///< blocks that nothing ties together
  BlockSet reached_{0};    ///< blocks that the planes in use can hold
  BlockRenderer renderer_;
  DirectionGuard guard_;
  std::optional<MonotoneEnvelope> envelope_;      ///< only where the scene asks for it
  std::optional<LinearCertificate> certificate_;  ///< only where the scene asks for it
  LocalProxy local_proxy_;
  DeviceStateMachine machine_;
  Gain gain_;
  DampingGain damping_gain_;
  Rate rate_;
  LateBucket late_bucket_;
  ForceLimiter limiters_[kMaxQ];
  std::optional<Passivity> passivity_;    ///< only where the scene asks for it
  std::optional<SpringStorage> coupled_;  ///< of Z_q in effect and gain 1; only where it is coupled
  std::optional<RatedActuators> ratings_;
  std::optional<ForceControl> force_control_;
  std::optional<PalmTracker> tracker_;  ///< only where the scene has one

  std::uint64_t ticks_{0};
  TimePoint last_now_{};
  FaultSet latched_{};
  FaultSet causes_{};            ///< faults whose cause is present in this tick
  bool ready_{false};            ///< a good sample was seen
  bool fresh_{false};            ///< in this very tick
  TimePoint last_sample_now_{};  ///< tick at which the newest good sample came
  double ladder_{0.0};
  bool has_proxy_{false};
  std::uint32_t last_epoch_{0};
  /// An Engage was accepted and neither Release, end of lease nor a fault has ended what it
  /// allowed: damping stays on after the elastic force was lost
  /// (proto/README.md#staleness-and-gain, level "lost").
  bool force_granted_{false};
  bool released_{false};
  bool engage_accepted_{false};

  EngageAnswer engage_{};
  ClearAnswer clear_{};
  std::uint64_t release_id_{0};
  std::uint64_t stop_id_{0};

  VecQ q_{};
  VecQ tracked_{};  ///< sensed()'s, where there is a tracker
  VecX dx_{};
  VecA dq_a_{};            ///< S (q* - q)
  VecA anchor_{};          ///< S q*, of the tank's spring
  VecA displayed_{};       ///< that spring's stiffness by Z_q, n_a; >= 1
  VecA tau_controller_{};  ///< the passivity controller's, n_a
  VecA tau_measured_{};    ///< with the newest sample; size 0: the device measures none
  VecA held_{};            ///< what the drives gave since the last tick, n_a; for their heat
  Projection projection_{};
  int weakest_{-1};  ///< the DoF whose limit is the coupled spring's
  bool map_ok_{false};
  bool has_anchor_{false};   ///< projection_.q_star is of the proxy in use
  bool project_anew_{true};  ///< the proxy changed since the renderer last saw it
};

}  // namespace haptic::core
