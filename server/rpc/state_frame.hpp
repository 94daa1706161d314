#pragma once
/// One DeviceState, serialised once per tick and shared by every stream that sends it.

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/slice.h>

#include <optional>
#include <span>

#include "google/protobuf/message_lite.h"
#include "haptic/core/projection/projection_model.hpp"
#include "haptic/core/tick/tick_record.hpp"
#include "haptic/v1/session.pb.h"
#include "server/session/device_sessions.hpp"

namespace haptic::server {

/// The state's bytes are one reference-counted slice; what differs between streams (the outer
/// field's tag, a watch's own counter) lies before and behind it. One thread, the telemetry
/// drain's.
class StateFrame {
 public:
  StateFrame() = default;
  /// Its states carry the coupling metric of this model, whose map must outlive the frame.
  StateFrame(const core::ProjectionModel& model, double softness)
      : coupling_(Coupling{model, softness}) {}
  /// A new tick; nothing is serialised before somebody asks. `record` must outlive the use.
  void begin(const core::TickRecord& record, DeviceSessions::Stamp stamp = {}) noexcept;
  /// SessionResponse { state }.
  [[nodiscard]] grpc::ByteBuffer for_session();
  /// DeviceState alone, as a datagram carries it; until the next begin().
  [[nodiscard]] std::span<const std::uint8_t> for_datagram();
  /// WatchResponse { state, conflated }.
  [[nodiscard]] grpc::ByteBuffer for_watch(std::uint64_t conflated);

 private:
  struct Coupling {
    core::ProjectionModel model;
    double softness;
  };
  void serialise();

  std::optional<Coupling> coupling_{};
  const core::TickRecord* record_{nullptr};
  DeviceSessions::Stamp stamp_{};
  bool ready_{false};
  v1::DeviceState state_{};
  grpc::Slice bytes_{};
};

[[nodiscard]] grpc::ByteBuffer to_buffer(const google::protobuf::MessageLite& message);

}  // namespace haptic::server
