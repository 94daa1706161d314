#pragma once
/// One DeviceState, serialised once per tick and shared by every stream that sends it.

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/slice.h>

#include "google/protobuf/message_lite.h"
#include "haptic/core/tick/tick_record.hpp"
#include "haptic/v1/session.pb.h"

namespace haptic::server {

/// The state's bytes are one reference-counted slice; what differs between streams (the outer
/// field's tag, a watch's own counter) lies before and behind it. One thread, the telemetry
/// drain's.
class StateFrame {
 public:
  /// A new tick; nothing is serialised before somebody asks. `record` must outlive the use.
  void begin(const core::TickRecord& record) noexcept;
  /// SessionResponse { state }.
  [[nodiscard]] grpc::ByteBuffer for_session();
  /// WatchResponse { state, conflated }.
  [[nodiscard]] grpc::ByteBuffer for_watch(std::uint64_t conflated);

 private:
  void serialise();

  const core::TickRecord* record_{nullptr};
  bool ready_{false};
  v1::DeviceState state_{};
  grpc::Slice bytes_{};
};

[[nodiscard]] grpc::ByteBuffer to_buffer(const google::protobuf::MessageLite& message);

}  // namespace haptic::server
