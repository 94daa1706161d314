#include <array>
#include <cstring>

#include "haptic/client/types.hpp"
#include "haptic/v1/session.pb.h"

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

/// The value's name without the prefix that all names of its enumeration share, as of value 0:
/// "KIND_UNSPECIFIED", "KIND_STATE" -> "STATE".
const char* word(const google::protobuf::EnumDescriptor* kind, int number) noexcept {
  const auto* value = kind->FindValueByNumber(number);
  if (number == 0 || value == nullptr) return "UNKNOWN";
  const std::size_t prefix = kind->value(0)->name().size() - std::strlen("UNSPECIFIED");
  return value->name().c_str() + prefix;
}

}  // namespace

std::vector<std::string> fault_names(std::uint32_t faults) {
  return names(faults, kFaults);
}

std::vector<std::string> limiter_names(std::uint32_t limiters) {
  return names(limiters, kLimiters);
}

const char* name(CertificateState::Status status) noexcept {
  return word(v1::CertificateStatus_descriptor(), static_cast<int>(status));
}

const char* name(Lifecycle state) noexcept {
  return word(v1::DeviceStateName_descriptor(), static_cast<int>(state));
}

const char* name(Staleness staleness) noexcept {
  return word(v1::StalenessLevel_descriptor(), static_cast<int>(staleness));
}

const char* name(Carrier carrier) noexcept {
  return word(v1::Transport_descriptor(), static_cast<int>(carrier));
}

}  // namespace haptic::client
