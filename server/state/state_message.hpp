#pragma once
/// The one place where a state becomes a v1::DeviceState: streams, datagrams and recordings say the
/// same of a tick.

#include <optional>

#include "haptic/core/rendering/coupling_metric.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "haptic/v1/session.pb.h"
#include "server/crossing/state_record.hpp"

namespace haptic::server {

class StateMessage {
 public:
  /// States without a coupling metric.
  StateMessage() = default;
  /// Of a device with this map, which must outlive the object. `coupling_softness`: states carry
  /// the coupling metric (core/METHOD.md#anisotropic-coupling).
  StateMessage(const core::PipelineConfig& config, std::optional<double> coupling_softness);

  /// Overwrites the message of the call before, and keeps its memory.
  const v1::DeviceState& write(const StateRecord& record);

 private:
  struct Coupling {
    core::ProjectionModel model;
    double softness;
  };
  std::optional<Coupling> coupling_{};
  v1::DeviceState state_{};
};

/// Bytes of a serialised DeviceState at most; `coupled`: with a coupling metric.
[[nodiscard]] std::size_t largest_state(const core::PipelineConfig& config, bool coupled = false);

}  // namespace haptic::server
