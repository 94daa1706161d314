#pragma once
/// Requests that the tick answers: posted as counters, answered by a record, or given up after a
/// bounded number of ticks.

#include <cstdint>
#include <functional>
#include <list>
#include <string>
#include <vector>

#include "haptic/core/tick/tick_record.hpp"
#include "server/session/refusal.hpp"

namespace haptic::server {

using Answer = std::function<void(const Outcome<Done>&)>;
using ClearAnswered = std::function<void(const Outcome<core::FaultSet>&)>;

/// Names a pending request, for cancel(); 0: it was answered at once.
using Ticket = std::uint64_t;

/// The faults that a ClearFault found, and the newest stop among them.
struct AskedClear {
  core::FaultSet faults{};
  std::uint64_t stop_id{0};
};

/// The book of open questions. Not thread-safe: the owner's mutex guards it. Answers are handed out
/// as closures, to be called when that mutex is free again.
class PendingRequests {
 public:
  /// Ticks after which a question is given up: 250 ms at 1 kHz.
  static constexpr int kPatience = 250;
  using Closures = std::vector<std::function<void()>>;
  /// Calls each, in order; with no lock held.
  static void run(const Closures& closures) {
    for (const auto& closure : closures) closure();
  }

  Ticket add_engage(std::uint64_t id, std::string session_id, Answer answer);
  Ticket add_release(std::uint64_t id, std::string session_id, Answer answer);
  Ticket add_stop(std::uint64_t id, Answer answer);
  /// Waits for its turn: one clear is under way at a time, or the second would overwrite the first
  /// in the newest-wins mailbox, and together they would clear more than each of them asked for.
  /// What it clears is what was there when it was asked: nothing that came while it waited.
  Ticket add_clear(const AskedClear& asked, ClearAnswered answer);
  [[nodiscard]] bool clear_waits() const noexcept;
  /// The clear that has waited longest is under way as `id`. Only where clear_waits().
  AskedClear begin_clear(std::uint64_t id) noexcept;

  /// Collects what `record` answers, and what has waited too long.
  void step(const core::TickRecord& record, Closures& closures);
  /// The session lost its lease: its engages are refused, its releases are fulfilled. Whether there
  /// was an engage: the loop may still read it.
  [[nodiscard]] bool lease_ended(const std::string& session_id, Closures& closures);
  enum class Cancelled : std::uint8_t { kNothing, kRequest, kEngage };
  /// Not kNothing where the request was still open; its answer is then never called.
  Cancelled cancel(Ticket ticket);

 private:
  enum class Kind : std::uint8_t { kEngage, kRelease, kStop, kClear };
  struct Request {
    Ticket ticket{0};
    Kind kind{Kind::kEngage};
    std::uint64_t id{0};  ///< 0: not posted yet
    int patience{kPatience};
    std::string session_id{};
    AskedClear clear{};
    Answer answer{};
    ClearAnswered cleared{};
  };
  Ticket add(Request request);
  static bool resolve(Request& request, const core::TickRecord& record, Closures& closures);

  std::list<Request> requests_;
  Ticket last_ticket_{0};
};

}  // namespace haptic::server
