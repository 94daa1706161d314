// The names of enumerators as states, recordings and the wire have them.
#include "haptic/core/names.hpp"

#include "haptic/core/fault.hpp"

namespace haptic::core {

std::string_view reason(Fault fault) noexcept {
  static constexpr std::array<std::string_view, 14> kNames{
      "UNKNOWN",           "DEVICE_SILENT",       "DEVICE_LOST",
      "SAMPLE_NOT_FINITE", "SAMPLE_OUT_OF_RANGE", "LOOP_LATE",
      "LATE_BUCKET_FULL",  "EMERGENCY_STOP",      "FORCE_OVER_LIMIT",
      "OUTPUT_NOT_FINITE", "FORCE_OUT_OF_RANGE",  "FORCE_TOO_FAST",
      "FORCE_STUCK",       "FORCE_DISAGREES"};
  return name_of(fault, kNames);
}

std::string_view reason(Limiter limiter) noexcept {
  static constexpr std::array<std::string_view, 21> kNames{
      "SATURATION",  "SLEW",        "ENVELOPE",          "DIRECTION_GUARD", "RANGE_CLAMP",
      "ENERGY_TANK", "PASSIVITY",   "INFEASIBLE_PLANES", "UNKNOWN",         "POWER",
      "RATE",        "TEMPERATURE", "DRIVE_LIMIT",       "CONTACTS",        "SINGULAR",
      "BRANCH",      "NEVER_FREE",  "DERATED",           "OUTSIDE_WINDOW",  "TOO_FAST",
      "NOT_FELT"};
  return name_of(limiter, kNames);
}

}  // namespace haptic::core
