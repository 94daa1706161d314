#pragma once
/// Messages that wait to be written on a stream. A stream writes one message at a time; only the
/// newest of the samples that come meanwhile is kept, and a farewell is the last message. This
/// class writes nothing itself: it says what to write next.

#include <cstdint>
#include <optional>

#include "haptic/v1/session.pb.h"

namespace haptic::client {

class Outbox {
 public:
  using Message = v1::SessionRequest;
  enum class State : std::uint8_t {
    kIdle,     ///< nothing is being written
    kWriting,  ///< a message is; a sample may wait behind it
    kLeaving,  ///< a message is, and the farewell follows it
    kOver,     ///< nothing is written any more
  };
  /// The meaning of a write that ended.
  struct Written {
    bool sample{false};            ///< a sample was handed over
    std::uint64_t replaced{0};     ///< so many samples before it gave way to newer ones
    const Message* next{nullptr};  ///< to be written now; null: nothing
  };

  /// Returns what is to be written now: the message, or null while it waits or is dropped.
  [[nodiscard]] const Message* put(Message message);
  /// The same for the farewell. No sample is written any more.
  [[nodiscard]] const Message* leave();
  [[nodiscard]] Written written(bool ok);
  void stop() noexcept { state_ = State::kOver; }
  [[nodiscard]] State state() const noexcept { return state_; }

 private:
  [[nodiscard]] const Message* farewell();

  State state_{State::kIdle};
  Message current_;  ///< must not change while it is written
  std::optional<Message> waiting_{};
  std::uint64_t replaced_{0};
};

}  // namespace haptic::client
