#pragma once
/// Who has what of a device: the lease, its epoch and clock, engage and release, settings within the
/// scene, clear and stop (WIRE 2). No gRPC here: time and records come in, verdicts go out, so that
/// every rule runs on virtual time.

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/tick/tick_record.hpp"
#include "server/ingress/ingress.hpp"
#include "server/rt/device_unit.hpp"
#include "server/telemetry/telemetry.hpp"

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

/// What a session may ask to change; absent and empty leave the setting as it is.
struct SettingsRequest {
  std::vector<double> stiffness{}, damping{}, force_limit{}, slew_limit{};
  std::optional<core::RendererKind> renderer{};
  std::optional<bool> direction_guard{};
};

struct SettingsClamp {
  std::string field{};  ///< "stiffness[0]"
  double asked{0.0};
  double applied{0.0};
  std::string why{};
};

struct SettingsAnswer {
  core::RenderSettings applied{};
  std::vector<SettingsClamp> clamped{};
};

/// A refusal with a stable reason ("LEASE_HELD", "NOT_ARMED", ...) and a sentence for people.
struct Refusal {
  enum class Code : std::uint8_t { kInvalid, kExists, kPrecondition, kPermission, kUnavailable };
  Code code{Code::kInvalid};
  std::string reason{};
  std::string message{};
  std::string field{};  ///< kInvalid: the field that is off
};

template <typename T>
struct Outcome {
  std::optional<T> value{};
  Refusal refusal{};
  explicit operator bool() const noexcept { return value.has_value(); }
};

}  // namespace haptic::server
