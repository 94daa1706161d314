#pragma once
/// Knows if the user wants force, and when to ask the server for it. This class neither reads a
/// clock nor calls the server: the session sends Engage and Release, and reports the answers here.

#include <chrono>
#include <cstdint>
#include <optional>

#include "haptic/client/error.hpp"

namespace haptic::client {

class Force {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  /// An Engage that was sent in the background.
  enum class Engage : std::uint8_t {
    kNone,
    kUnderWay,
    kTakenBack,  ///< under way, but release() came since: a force that it brings is released again
  };

  /// `again`: ask again whenever force was lost. `next_lease`: and under the lease that follows one
  /// that is over, so that a refusal for want of a lease does not end the asking.
  Force(bool again, bool next_lease) noexcept : again_(again), next_lease_(next_lease) {}

  void want(TimePoint now);
  /// The user gives force up. `take_back`: the caller cannot wait for the Engage under way.
  void release(bool take_back);
  /// Ends the asking for a reason that waiting must not cure; refusal() says it.
  void give_up(const ClientError& why);
  /// A state that arrived at `now` says FAULT.
  void fault_seen(TimePoint now);

  /// When to send Engage next; empty: not now.
  [[nodiscard]] std::optional<TimePoint> due() const noexcept;
  void ask_at(TimePoint due) noexcept { due_ = due; }
  void asked() noexcept { engage_ = Engage::kUnderWay; }
  /// The answer to Engage. `refused` is empty if the server agreed; `same_session` is false if the
  /// session that asked is not the one that is open now. True: a Release has to follow.
  [[nodiscard]] bool answered(const std::optional<ClientError>& refused, bool same_session,
                              TimePoint now);

  /// A Release could not be sent, because there was no stream. The next opening must not resume the
  /// session; if it resumed it already, it has to release.
  void owe_release(bool owed) noexcept { release_owed_ = owed; }
  [[nodiscard]] bool owes_release() const noexcept { return release_owed_; }

  [[nodiscard]] bool wanted() const noexcept { return wanted_; }
  [[nodiscard]] Engage engage() const noexcept { return engage_; }
  [[nodiscard]] const std::optional<ClientError>& refusal() const noexcept { return refusal_; }

 private:
  const bool again_, next_lease_;
  bool wanted_{false};
  bool release_owed_{false};
  Engage engage_{Engage::kNone};
  TimePoint asked_at_{};  ///< when the user last asked
  TimePoint due_{};
  std::optional<ClientError> refusal_{};
};

}  // namespace haptic::client
