#pragma once
/// The lease: who may stream proxies to a device, since when, and until when (WIRE 2).

#include <cstdint>
#include <optional>
#include <string>

#include "haptic/core/safety/staleness.hpp"
#include "haptic/core/time.hpp"

namespace haptic::server {

/// A lease that was granted.
struct Lease {
  std::uint32_t epoch{0};
  core::StalenessLimits staleness{};  ///< in force
};

struct LeaseRequest {
  std::string session_id{};
  std::string client_name{};
  double nominal_rate_hz{0.0};
  std::optional<core::Duration> fresh_end{};
  std::optional<core::Duration> hold_end{};
  std::optional<core::Duration> fade_end{};
};

/// Exactly one holder or none, and an epoch that only rises. The clock of a lease runs from its
/// last accepted sample, or from its opening before the first one; at `timeout` it has expired.
class LeaseBook {
 public:
  explicit LeaseBook(core::Duration timeout) : timeout_(timeout) {}

  [[nodiscard]] bool held() const noexcept { return held_; }
  [[nodiscard]] bool held_by(const std::string& session_id) const noexcept {
    return held_ && session_id == session_id_;
  }
  [[nodiscard]] const std::string& session_id() const noexcept { return session_id_; }
  [[nodiscard]] const std::string& client_name() const noexcept { return client_name_; }
  [[nodiscard]] std::uint32_t epoch() const noexcept { return epoch_; }
  [[nodiscard]] core::Duration timeout() const noexcept { return timeout_; }

  /// A new lease under a new epoch. Precondition: !held().
  std::uint32_t grant(std::string session_id, std::string client_name,
                      core::TimePoint now) noexcept;
  void end() noexcept;
  /// `last_accepted`: of the ingress, under this lease; older than the opening before the first
  /// one.
  [[nodiscard]] bool expired(core::TimePoint now, core::TimePoint last_accepted) const noexcept;

 private:
  core::Duration timeout_;
  bool held_{false};
  std::uint32_t epoch_{0};
  core::TimePoint opened_{};
  std::string session_id_{};
  std::string client_name_{};
};

}  // namespace haptic::server
