#pragma once
/// The proxy between two samples: how x moves at 1 kHz while the simulation is silent (METHOD 5.4).
/// held: x stays. free: x is the haptic probe itself, so that no force and no drag arise; a client
/// that falls silent in free space leaves nothing behind that could pull.

#include "haptic/core/tick/tick_input.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

class LocalProxy {
 public:
  /// Takes over an accepted sample; one that is already in use changes nothing.
  void accept(const ProxySnapshot& sample) noexcept;
  /// No proxy from now on.
  void forget() noexcept;

  /// The proxy at this tick, given the haptic probe; empty where there is none.
  [[nodiscard]] const VecX& at(const VecX& x_probe) noexcept;
  /// True on the first call of at() after x changed by a new sample.
  [[nodiscard]] bool changed() const noexcept { return changed_; }

  [[nodiscard]] const ProxySnapshot& sample() const noexcept { return sample_; }
  [[nodiscard]] ProxyMode mode() const noexcept { return sample_.mode; }

 private:
  ProxySnapshot sample_{};
  VecX x_{};
  bool pending_{false};
  bool changed_{false};
};

}  // namespace haptic::core
