#pragma once
/// The one place where a tick's record becomes a v1::DeviceState: what streams, datagrams and
/// recordings say of a tick is the same.

#include <optional>

#include "haptic/core/analysis/coupling_metric.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "haptic/core/tick/tick_record.hpp"
#include "haptic/v1/session.pb.h"
#include "server/session/device_sessions.hpp"

namespace haptic::server {

class StateMessage {
 public:
  /// States without a coupling metric.
  StateMessage() = default;
  /// Of a device with this map, which must outlive the object. `coupling_softness`: states carry
  /// the coupling metric (core/METHOD.md#anisotropic-coupling).
  StateMessage(const core::PipelineConfig& config, std::optional<double> coupling_softness);

  /// Overwrites the message of the call before, and keeps its memory.
  const v1::DeviceState& write(const core::TickRecord& record, DeviceSessions::Stamp stamp = {});

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
