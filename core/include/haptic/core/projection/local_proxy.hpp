#pragma once
/// The proxy between two samples: how x moves at 1 kHz while the simulation is silent
/// (core/METHOD.md#local-models). held: x stays. free: x is the haptic probe itself, so that no
/// force and no drag arise; a client that falls silent in free space leaves nothing behind that
/// could pull. planes: x is the haptic probe, kept out of the sample's planes; where none is in the
/// way it is as free.

#include "haptic/core/model/configuration_space.hpp"
#include "haptic/core/projection/plane_projection.hpp"
#include "haptic/core/projection/proxy_snapshot.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

class LocalProxy {
 public:
  /// `space` must outlive this. `metric`: W_x, in which planes keep x out by the shortest way.
  explicit LocalProxy(const ConfigurationSpace& space, TaskMetric metric = {})
      : projection_(space, std::move(metric)) {}

  /// Takes over an accepted sample; one that is already in use changes nothing.
  void accept(const ProxySnapshot& sample) noexcept;
  /// No proxy from now on.
  void forget() noexcept;
  /// A sample was taken over that at() has not used yet.
  [[nodiscard]] bool pending() const noexcept { return pending_; }

  /// The proxy at this tick, given the haptic probe; empty where there is none.
  [[nodiscard]] const VecX& at(const VecX& x_probe) noexcept;
  /// Of the last at(): something is in the way, x is not simply the haptic probe.
  [[nodiscard]] bool constrained() const noexcept { return constrained_; }
  /// Of the last at(): x may differ from the one before it.
  [[nodiscard]] bool changed() const noexcept { return changed_; }
  [[nodiscard]] PlaneStatus planes() const noexcept { return planes_; }
  /// Of the last at(): bit i, plane i of the sample holds x.
  [[nodiscard]] std::uint32_t active_planes() const noexcept { return active_planes_; }

  [[nodiscard]] const ProxySnapshot& sample() const noexcept { return sample_; }
  [[nodiscard]] ProxyMode mode() const noexcept { return sample_.mode; }

 private:
  ProxySnapshot sample_{};
  PlaneProjection projection_;
  VecX x_{};
  PlaneStatus planes_{PlaneStatus::kFree};
  std::uint32_t active_planes_{0};
  bool pending_{false};
  bool changed_{false};
  bool constrained_{false};
};

}  // namespace haptic::core
