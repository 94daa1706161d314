#pragma once
/// The one place where a state becomes a v1::DeviceState: streams, datagrams and recordings say the
/// same of a tick.

#include "haptic/core/tick/pipeline.hpp"
#include "haptic/v1/session.pb.h"
#include "server/crossing/state_record.hpp"

namespace haptic::server {

class StateMessage {
 public:
  /// Overwrites the message of the call before, and keeps its memory.
  const v1::DeviceState& write(const StateRecord& record) {
    haptic::server::write(record, state_);
    return state_;
  }

 private:
  v1::DeviceState state_{};
};

/// Bytes of a serialised DeviceState at most.
[[nodiscard]] std::size_t largest_state(const core::PipelineConfig& config);

}  // namespace haptic::server
