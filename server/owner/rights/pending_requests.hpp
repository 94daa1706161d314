#pragma once
/// Requests that the tick answers: posted to it as counters, answered by a record, or given up
/// after a bounded number of ticks.

#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/tick/tick_record.hpp"
#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// The faults that a clear found, and the newest stop among them.
struct AskedClear {
  core::FaultSet faults{};
  std::uint64_t stop_id{0};
};

/// Why no force begins, in one sentence; nothing if it does. `state`: of the device.
[[nodiscard]] std::optional<Refusal> engage_refusal(const core::EngageAnswer& answer,
                                                    core::LifecycleState state);
/// "500 samples/s come, 60 were announced: ...".
[[nodiscard]] std::string too_fast(const core::StreamRate& rate);

class PendingRequests {
 public:
  using Answers = std::vector<Answer>;
  /// Ticks after which a request is given up: 250 ms at 1 kHz.
  static constexpr int kPatience = 250;

  /// An engage, release or stop that was posted to the loop as number `posted`.
  void add(const Request& request, std::uint64_t posted);
  /// Waits for its turn: only one clear is under way at a time, because a second one would
  /// overwrite the first in the newest-wins mailbox, and together they would clear more than each
  /// asked for. It clears what was there when it was asked, and nothing that came while it waited.
  void add_clear(const Request& request, const AskedClear& asked);
  /// If no clear is under way, the one that has waited longest is from now on, as `posted`; absent:
  /// none waits for that.
  std::optional<AskedClear> begin_clear(std::uint64_t posted) noexcept;

  /// Appends an answer for what `record` answers, and for what has waited too long. True if that
  /// was an engage: the loop may still read it.
  bool step(const core::TickRecord& record, Answers& answers);
  /// The session lost its lease: its engages are refused, its releases fulfilled. True if there was
  /// an engage: the loop may still read it.
  [[nodiscard]] bool lease_ended(const SessionId& session_id, Answers& answers);
  /// Request `id` is not answered any more. True if it was an engage, also if it is the newest one
  /// that was accepted: its answer came too late.
  bool cancel(std::uint64_t id);
  /// No cancel takes an engage back that was accepted before.
  void forget_engage() noexcept { accepted_engage_ = 0; }
  /// Every request is refused: no tick comes any more.
  void refuse_all(const Refusal& why, Answers& answers);

 private:
  struct Pending {
    std::uint64_t id{0};
    Request::Kind kind{Request::Kind::kEngage};
    std::uint64_t posted{0};  ///< 0: not yet
    SessionId session_id{};
    AskedClear clear{};
    int patience{kPatience};
  };
  /// True if the record answers it.
  bool resolve(const Pending& pending, const core::TickRecord& record, Answers& answers);

  std::list<Pending> requests_;
  std::uint64_t accepted_engage_{0};  ///< id of the newest request; 0: none
};

}  // namespace haptic::server
