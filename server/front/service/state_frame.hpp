#pragma once
/// One DeviceState's bytes, shared by every stream that sends it.

#include <memory>
#include <span>
#include <string>
#include <utility>

#include "google/protobuf/message_lite.h"
#include "server/crossing/serialised_state.hpp"

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

/// One thread's.
class StateFrame {
 public:
  /// `state` must outlive it. Its bytes are copied when the first stream asks.
  explicit StateFrame(const SerialisedState& state) : state_(state) {}
  /// SessionResponse { state }.
  [[nodiscard]] Outgoing for_session();
  /// DeviceState alone, as a datagram carries it.
  [[nodiscard]] std::span<const std::uint8_t> for_datagram() const { return state_.message(); }
  /// WatchResponse { state, conflated }.
  [[nodiscard]] Outgoing for_watch(std::uint64_t conflated);

 private:
  /// `field`: of the message that holds the state.
  [[nodiscard]] Outgoing framed(int field);

  const SerialisedState& state_;
  std::shared_ptr<const std::string> bytes_{};  ///< null: no stream asked yet
};

}  // namespace haptic::server
