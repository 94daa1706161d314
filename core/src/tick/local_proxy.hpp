#pragma once
/// The proxy between two samples: how x moves at 1 kHz while the simulation is silent
/// (core/METHOD.md#local-models). held: x stays. free: x is the haptic probe itself, so that no
/// force and no drag arise; a client that falls silent in free space leaves nothing behind that
/// could pull. planes: x is the haptic probe, kept out of the sample's planes; while none is in the
/// way it is as free.

#include "haptic/core/model/configuration_space.hpp"
#include "haptic/core/projection/plane_projection.hpp"
#include "haptic/core/tick/tick_record.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

class LocalProxy {
 public:
  /// `space` must outlive this. `metric`: W_x, in which planes keep x out by the shortest way.
  explicit LocalProxy(const ConfigurationSpace& space, TaskMetric metric = {})
      : projection_(space, std::move(metric)) {}

  /// From the sample in use and the haptic probe: writes x (n_x; empty if there is no sample),
  /// in_the_way, planes and active_planes of a new Anchor.
  void step(const ProxySnapshot& sample, const VecX& x_probe, Anchor& now) noexcept;

  // Of the last step:
  /// Null unless the sample has planes.
  [[nodiscard]] const Contacts* contacts() const noexcept {
    return mode_ == ProxyMode::kPlanes ? &projection_.contacts() : nullptr;
  }
  /// The sample is another one than in the step before.
  [[nodiscard]] bool new_sample() const noexcept { return new_sample_; }
  /// x may differ from the one of the step before.
  [[nodiscard]] bool changed() const noexcept { return changed_; }

 private:
  ProxyMode mode_{ProxyMode::kNone};  ///< these three: which sample the last step was given
  std::uint32_t tenure_{0};
  std::uint64_t seq_{0};
  PlaneProjection projection_;
  bool new_sample_{false};
  bool changed_{false};
};

}  // namespace haptic::core
