#pragma once
/// One DeviceState, serialised once per tick and shared by every stream that sends it.

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/slice.h>

#include <span>
#include <utility>

#include "google/protobuf/message_lite.h"
#include "server/state/state_message.hpp"

namespace haptic::server {

/// The state's bytes are one reference-counted slice; what differs between streams (the outer
/// field's tag, a watch's own counter) lies before and behind it. One thread, the telemetry
/// drain's.
class StateFrame {
 public:
  StateFrame() = default;
  explicit StateFrame(StateMessage message) : message_(std::move(message)) {}
  /// A new state; nothing is serialised before a stream asks. `state` must outlive the use.
  void begin(const StateRecord& state) noexcept;
  /// SessionResponse { state }.
  [[nodiscard]] grpc::ByteBuffer for_session();
  /// DeviceState alone, as a datagram carries it; until the next begin().
  [[nodiscard]] std::span<const std::uint8_t> for_datagram();
  /// WatchResponse { state, conflated }.
  [[nodiscard]] grpc::ByteBuffer for_watch(std::uint64_t conflated);

 private:
  void serialise();

  StateMessage message_{};
  const StateRecord* record_{nullptr};
  bool ready_{false};
  grpc::Slice bytes_{};
};

[[nodiscard]] grpc::ByteBuffer to_buffer(const google::protobuf::MessageLite& message);

}  // namespace haptic::server
