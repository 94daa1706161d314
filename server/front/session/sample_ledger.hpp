#pragma once
/// The fate of a session's samples, and when to tell the client.

#include "haptic/core/time.hpp"
#include "haptic/v1/session.pb.h"
#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// Acknowledgements are totals, so none is lost by sending few: one every 50 ms while samples come,
/// and one within 10 ms of a rejection, so that a mistake is soon seen. Not thread-safe.
class SampleLedger {
 public:
  static constexpr core::Duration kEvery{std::chrono::milliseconds(50)};
  static constexpr core::Duration kEveryRejected{std::chrono::milliseconds(10)};

  void book(std::uint64_t seq, const Verdict& verdict);
  /// Decides whether an acknowledgement is due at `now`.
  void look(core::TimePoint now) noexcept;
  [[nodiscard]] bool due() const noexcept { return due_; }
  /// The acknowledgement, which is thereby told.
  [[nodiscard]] const v1::SampleAck& tell() noexcept;

 private:
  v1::SampleAck ack_{};
  bool changed_{false};
  bool rejected_{false};
  bool due_{false};
  core::TimePoint now_{};
  core::TimePoint told_{};
};

}  // namespace haptic::server
