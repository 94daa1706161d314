#pragma once
/// The proxy between two samples: how x moves at 1 kHz while the simulation is silent
/// (core/METHOD.md#local-models). held: x stays. free: x is the haptic probe itself, so that no
/// force and no drag arise; a client that falls silent in free space leaves nothing behind that
/// could pull. planes: x is the haptic probe, kept out of the sample's planes; while none is in the
/// way it is as free.

#include "haptic/core/model/configuration_space.hpp"
#include "haptic/core/projection/plane_projection.hpp"
#include "haptic/core/tick/tick_input.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

class LocalProxy {
 public:
  /// `space` must outlive this. `metric`: W_x, in which planes keep x out by the shortest way.
  explicit LocalProxy(const ConfigurationSpace& space, TaskMetric metric = {})
      : projection_(space, std::move(metric)) {}

  /// The proxy at this tick, n_x, given the sample in use and the haptic probe; empty if there is
  /// no sample. Valid as long as both arguments are, and until the next step.
  [[nodiscard]] const VecX& step(const ProxySnapshot& sample, const VecX& x_probe) noexcept;

  // Of the last step:
  /// Something is in the way: x is not simply the haptic probe.
  [[nodiscard]] bool in_the_way() const noexcept { return in_the_way_; }
  /// The sample is another one than in the step before.
  [[nodiscard]] bool new_sample() const noexcept { return new_sample_; }
  /// x may differ from the one of the step before.
  [[nodiscard]] bool changed() const noexcept { return changed_; }
  [[nodiscard]] PlaneStatus planes() const noexcept { return planes_; }
  /// Bit i: plane i of the sample holds x.
  [[nodiscard]] std::uint32_t active_planes() const noexcept { return active_planes_; }

 private:
  ProxyMode mode_{ProxyMode::kNone};  ///< these three: which sample the last step was given
  std::uint32_t tenure_{0};
  std::uint64_t seq_{0};
  PlaneProjection projection_;
  VecX x_{};
  PlaneStatus planes_{PlaneStatus::kFree};
  std::uint32_t active_planes_{0};
  bool new_sample_{false};
  bool changed_{false};
  bool in_the_way_{false};
};

}  // namespace haptic::core
