#pragma once
/// The one place where a state becomes a v1::DeviceState: streams, datagrams and recordings say the
/// same of a tick.

#include "haptic/core/tick/pipeline.hpp"
#include "haptic/v1/session.pb.h"
#include "server/crossing/serialised_state.hpp"
#include "server/crossing/values.hpp"

namespace haptic::server {

/// A tick's record, and what the owner knows of it but the loop does not.
struct TickTold {
  const core::TickRecord& record;
  Carrier carrier{Carrier::kNone};  ///< of the proxy in use
  std::uint32_t lease_epoch{0};     ///< of its lease as clients know it
};

/// Overwrites the fields of `to`, and keeps its memory. Made of the message's options (from), by
/// proto/generate.
void write(const TickTold& from, v1::DeviceState& to);
/// `state` is write() of the record.
void serialise(const core::TickRecord& record, const v1::DeviceState& state, SerialisedState& to);

/// Bytes of a serialised DeviceState at most.
[[nodiscard]] std::size_t largest_state(const core::PipelineConfig& config);

}  // namespace haptic::server
