#pragma once
#include "haptic/core/tick/pipeline.hpp"

namespace haptic::bench {

/// What tick `i` (from 0, 1 ms apart) of an engaged device is given: the fresh sample q (n_q), and
/// the proxy x (n_x) held, as a client at 60 Hz sends it.
inline core::TickInput held_tick(const core::PipelineConfig& config, int i, const core::VecQ& q,
                                 const core::VecX& x) {
  core::TickInput input;
  input.now = core::TimePoint(std::chrono::milliseconds(i + 1));
  input.settings = config.scene;
  input.device.fresh = input.device.armed = true;
  input.device.sample.seq = static_cast<std::uint64_t>(i);
  input.device.sample.time = input.now;
  input.device.sample.q = q;
  input.command.tenure = 1;
  input.command.lease_held = true;
  input.command.engage_id = i > 250 ? 1 : 0;
  input.proxy.mode = core::ProxyMode::kHeld;
  input.proxy.tenure = 1;
  input.proxy.seq = static_cast<std::uint64_t>(i / 16 + 1);
  input.proxy.gapless_samples = static_cast<std::uint64_t>(i);
  input.proxy.born = input.now;
  input.proxy.x = x;
  return input;
}

}  // namespace haptic::bench
