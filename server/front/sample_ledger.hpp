#pragma once
/// What became of a session's samples, and when to tell it.

#include <string>
#include <utility>

#include "haptic/core/time.hpp"
#include "haptic/v1/session.pb.h"
#include "server/ingress/ingress.hpp"

namespace haptic::server {

/// Acknowledgements are totals, so none is lost by sending few: one every 50 ms while samples come,
/// and one within 10 ms of a rejection, because somebody is looking for a mistake. Not thread-safe.
class SampleLedger {
 public:
  static constexpr core::Duration kEvery{std::chrono::milliseconds(50)};
  static constexpr core::Duration kEveryRejected{std::chrono::milliseconds(10)};

  void book(std::uint64_t seq, IngressVerdict verdict, std::string why);
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
