#pragma once
/// A client's samples of a held proxy, for a pipeline that a test drives itself.

#include "haptic/core/tick/pipeline.hpp"

namespace haptic::test {

/// Makes `proxy` the next sample: `x`, born now, under the tenure of `input`. The first one is
/// free: the probe came from outside.
inline void publish_held(const core::TickInput& input, const core::VecX& x,
                         core::ProxySnapshot& proxy) {
  proxy.tenure = input.command.tenure;
  proxy.x = x;
  proxy.born = input.now;
  proxy.mode = ++proxy.seq == 1 ? core::ProxyMode::kFree : core::ProxyMode::kHeld;
  if (proxy.seq == 1) proxy.gapless_since = input.now;
  ++proxy.gapless_samples;
}

}  // namespace haptic::test
