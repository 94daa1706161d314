#include <array>

#include "haptic/client/types.hpp"

namespace haptic::client {

namespace {

// Numbers as in proto/README.md; fault 0 is no fault.
constexpr std::array<const char*, 10> kFaults{
    "",          "DEVICE_SILENT",    "DEVICE_LOST",    "SAMPLE_NOT_FINITE", "SAMPLE_OUT_OF_RANGE",
    "LOOP_LATE", "LATE_BUCKET_FULL", "EMERGENCY_STOP", "FORCE_OVER_LIMIT",  "OUTPUT_NOT_FINITE"};
constexpr std::array<const char*, 13> kLimiters{
    "SATURATION",  "SLEW",        "ENVELOPE",          "DIRECTION_GUARD",   "RANGE_CLAMP",
    "ENERGY_TANK", "PASSIVITY",   "INFEASIBLE_PLANES", "MONOTONE_ENVELOPE", "POWER",
    "RATE",        "TEMPERATURE", "DRIVE_LIMIT"};

/// A bit without a name is of a newer server: its number stands for it.
template <std::size_t N>
std::vector<std::string> names(std::uint32_t bits, const std::array<const char*, N>& known) {
  std::vector<std::string> found;
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    if ((bits >> bit & 1U) == 0) continue;
    const bool named = bit < N && *known.at(bit) != '\0';
    found.push_back(named ? std::string(known.at(bit)) : std::to_string(bit));
  }
  return found;
}

}  // namespace

std::vector<std::string> fault_names(std::uint32_t faults) {
  return names(faults, kFaults);
}

std::vector<std::string> limiter_names(std::uint32_t limiters) {
  return names(limiters, kLimiters);
}

const char* name(CertificateState::Status status) noexcept {
  switch (status) {
    case CertificateState::Status::kUnknown:
      break;
    case CertificateState::Status::kComputed:
      return "COMPUTED";
    case CertificateState::Status::kIdle:
      return "IDLE";
    case CertificateState::Status::kOtherRenderer:
      return "OTHER_RENDERER";
    case CertificateState::Status::kMapFailed:
      return "MAP_FAILED";
    case CertificateState::Status::kNotFullRank:
      return "NOT_FULL_RANK";
    case CertificateState::Status::kNoStiffness:
      return "NO_STIFFNESS";
  }
  return "UNKNOWN";
}

const char* name(Lifecycle state) noexcept {
  switch (state) {
    case Lifecycle::kInit:
      return "INIT";
    case Lifecycle::kIdle:
      return "IDLE";
    case Lifecycle::kArmed:
      return "ARMED";
    case Lifecycle::kEngaging:
      return "ENGAGING";
    case Lifecycle::kEngaged:
      return "ENGAGED";
    case Lifecycle::kReleasing:
      return "RELEASING";
    case Lifecycle::kFault:
      return "FAULT";
    case Lifecycle::kClosing:
      return "CLOSING";
    case Lifecycle::kUnknown:
      break;
  }
  return "UNKNOWN";
}

const char* name(Staleness staleness) noexcept {
  switch (staleness) {
    case Staleness::kFresh:
      return "FRESH";
    case Staleness::kHold:
      return "HOLD";
    case Staleness::kFade:
      return "FADE";
    case Staleness::kLost:
      return "LOST";
    case Staleness::kUnknown:
      break;
  }
  return "UNKNOWN";
}

const char* name(Carrier carrier) noexcept {
  switch (carrier) {
    case Carrier::kGrpc:
      return "GRPC";
    case Carrier::kUdp:
      return "UDP";
    case Carrier::kUnknown:
      break;
  }
  return "UNKNOWN";
}

}  // namespace haptic::client
