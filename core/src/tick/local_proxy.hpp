#pragma once
/// The proxy between two samples: how x moves at 1 kHz while the simulation is silent
/// (core/METHOD.md#local-models). held: x goes to the newest sample's and stays, but coordinates
/// equal to the probe that the client saw keep following the probe. free: x is the haptic probe
/// itself, so that no force and no drag arise; a client that falls silent in free space leaves
/// nothing behind that could pull. planes: x is the haptic probe, kept out of the sample's planes,
/// or the proxy against its contacts (core/METHOD.md#contacts); while none is in the way it is as
/// free.

#include <bitset>

#include "haptic/core/contacts/plane_projection.hpp"
#include "haptic/core/model/configuration_space.hpp"
#include "haptic/core/tick/tick_record.hpp"
#include "haptic/core/types.hpp"
#include "probe_history.hpp"

namespace haptic::core {

class LocalProxy {
 public:
  struct Moment {
    std::uint64_t tick{0};  ///< rises by one from step to step
    double age{0.0};        ///< of the sample, s
    TimePoint now{};        ///< rises with it
  };

  /// `space` must outlive this. `metric`: W_x, in which planes keep x out by the shortest way.
  explicit LocalProxy(const ConfigurationSpace& space, TaskMetric metric = {})
      : space_(space), projection_(space, std::move(metric)), past_(space.n_x()) {}

  /// From the sample in use and the haptic probe: writes x (n_x; empty if there is no sample),
  /// in_the_way, planes, active_planes, stored, coupling and unexplained of a new Anchor.
  void step(const ProxySnapshot& sample, const Moment& moment, const VecX& x_probe,
            Anchor& now) noexcept;

  // Results of the last step:
  /// How far the simulation's own proxy may be from x.
  [[nodiscard]] const ProxyError& error() const noexcept { return error_; }
  /// Null unless the sample has planes.
  [[nodiscard]] const Contacts* contacts() const noexcept {
    return mode_ == ProxyMode::kPlanes ? &projection_.contacts() : nullptr;
  }
  /// The sample is another one than in the step before.
  [[nodiscard]] bool new_sample() const noexcept { return new_sample_; }
  /// x may differ from the one of the step before.
  [[nodiscard]] bool changed() const noexcept { return changed_; }

 private:
  /// In which coordinates a held sample is the probe that its simulation saw. `goes_on`: so was the
  /// sample before it, of the same lease.
  void find_free(const ProxySnapshot& sample, bool goes_on) noexcept;
  void follow(const VecX& x_probe, VecX& x) const noexcept;
  /// A new held sample: x goes to it from where it is, within the time that it came after the one
  /// before. `goes_on`: that was held, too.
  void set_out(const VecX& to, bool goes_on, const std::bitset<kMaxX>& free_before,
               TimePoint now) noexcept;
  /// x, the newest sample's, on that way in this tick, `dt` s after the last. False: it was there.
  [[nodiscard]] bool go_on(TimePoint now, double dt, VecX& x) noexcept;
  /// How far that age may be off, s: the simulation did not compute it before the tick that it
  /// used, nor after its arrival.
  [[nodiscard]] double age_error(const ProxySnapshot& sample, const Moment& moment) const noexcept;
  /// The objects of the sample before are taken to the tick of the next one, which tells how fast
  /// they became by then.
  void compare(std::uint64_t next, VecX& x) noexcept;
  /// Projects the probe of that tick.
  void project_at(std::uint64_t tick, const Moment& moment, double dt, VecX& x) noexcept;
  /// Objects that are pushed go on from the tick from which the sample was computed, by the probes
  /// of the ticks since then, to the last one.
  void replay(const Moment& moment, VecX& x) noexcept;
  /// From the tick `from`, where objects are, to `last`. `moment`: has the sample's age. In longer
  /// steps than ticks if those are more than `steps`.
  void run(std::uint64_t from, std::uint64_t last, const Moment& moment, int steps,
           VecX& x) noexcept;

  const ConfigurationSpace& space_;
  ProxyMode mode_{ProxyMode::kNone};  ///< these three: which sample the last step was given
  std::uint32_t tenure_{0};
  std::uint64_t seq_{0};
  PlaneProjection projection_;
  ProbeHistory past_;
  ProxyError error_{};
  std::uint64_t began_{0};     ///< the tick of the sample in use, if it has laws and that is known
  VecX used_{};                ///< the probe from which the sample was computed
  TimePoint used_time_{};      ///< when it was there, if the sample is anchored
  VecX held_{};                ///< x of the newest held sample
  VecX dx_{};                  ///< to that from used_
  std::bitset<kMaxX> free_{};  ///< coordinates of the held sample that follow the probe
  TimePoint came_{};           ///< when it came
  double way_s_{0.0};          ///< how long x is on its way to it; 0: it is there
  VecX from_{}, way_{};        ///< where x was then, and x (-) from_ of it
  VecX last_{};                ///< x of the last tick
  bool new_sample_{false};
  bool changed_{false};
};

}  // namespace haptic::core
