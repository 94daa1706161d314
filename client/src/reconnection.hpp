#pragma once
/// Knows if a session has a stream, and when the next attempt at one is due. This class neither
/// reads a clock nor opens a stream: the session does, and reports here what came of it.

#include <chrono>
#include <cstdint>

#include "haptic/client/error.hpp"

namespace haptic::client {

class Reconnection {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  enum class State : std::uint8_t {
    kOver,       ///< no stream: there was none yet, or no attempt follows
    kOpening,    ///< OpenSession was sent and not answered yet
    kOpen,       ///< the session has a stream
    kLeaseLost,  ///< the same, but its lease expired or was preempted: the session only observes
    kEnded,      ///< the stream ended; retry() decides what follows
    kWaiting,    ///< the next attempt is due at due()
    kClosed,     ///< the user closed the session: no attempt follows
  };

  /// `wanted`: whether the session takes up a lost stream again.
  explicit Reconnection(bool wanted) noexcept : wanted_(wanted) {}

  /// An attempt begins. False: the session was closed.
  [[nodiscard]] bool begin() noexcept;
  void opened() noexcept;
  void lease_lost() noexcept;
  /// The stream ended, or the opening failed. Without effect if there was neither.
  void ended(const ClientError& why);
  /// After ended(): true if another attempt follows. The first one is due at once, the next after
  /// 0.1, 0.2, 0.4, 0.5, 0.5 ... s. None follows a refusal that no waiting changes, such as a wrong
  /// argument.
  [[nodiscard]] bool retry(TimePoint now);
  void close() noexcept { state_ = State::kClosed; }

  [[nodiscard]] State state() const noexcept { return state_; }
  /// kOpen or kLeaseLost.
  [[nodiscard]] bool open() const noexcept;
  [[nodiscard]] bool closed() const noexcept { return state_ == State::kClosed; }
  /// No stream, and none will follow.
  [[nodiscard]] bool over() const noexcept { return state_ == State::kOver || closed(); }
  /// Why the last stream ended.
  [[nodiscard]] const ClientError& why() const noexcept { return why_; }
  /// While kWaiting; otherwise never.
  [[nodiscard]] TimePoint due() const noexcept;

 private:
  const bool wanted_;
  State state_{State::kOver};
  ClientError why_{ErrorReason::kClosed, "the session ended"};
  std::chrono::milliseconds delay_{0};  ///< before the next attempt
  TimePoint due_{};
};

}  // namespace haptic::client
