#pragma once
/// One DeviceState, serialised once per tick and shared by every stream that sends it.

#include <memory>
#include <span>
#include <string>
#include <utility>

#include "google/protobuf/message_lite.h"
#include "server/state/state_message.hpp"

namespace haptic::server {

/// A serialised message on its way to one client: three parts in a row. What streams share lies in
/// the middle; what differs (the outer field's tag, a watch's own counter) before and behind it.
struct Outgoing {
  std::string head{};
  std::shared_ptr<const std::string> shared{};  ///< null: empty
  std::string tail{};

  [[nodiscard]] std::size_t size() const noexcept {
    return head.size() + (shared ? shared->size() : 0) + tail.size();
  }
};

[[nodiscard]] Outgoing to_outgoing(const google::protobuf::MessageLite& message);

/// One thread, the telemetry drain's.
class StateFrame {
 public:
  /// A new state; nothing is serialised before a stream asks. `state` must outlive the use.
  void begin(const StateRecord& state) noexcept;
  /// SessionResponse { state }.
  [[nodiscard]] Outgoing for_session();
  /// DeviceState alone, as a datagram carries it; until the next begin().
  [[nodiscard]] std::span<const std::uint8_t> for_datagram();
  /// WatchResponse { state, conflated }.
  [[nodiscard]] Outgoing for_watch(std::uint64_t conflated);

 private:
  void serialise();

  StateMessage message_{};
  const StateRecord* record_{nullptr};
  std::shared_ptr<const std::string> bytes_{};  ///< null: not serialised yet
};

}  // namespace haptic::server
