#include "haptic/core/fault.hpp"

namespace haptic::core {

std::string_view reason(Fault fault) noexcept {
  switch (fault) {
    case Fault::kDeviceSilent:
      return "DEVICE_SILENT";
    case Fault::kDeviceLost:
      return "DEVICE_LOST";
    case Fault::kSampleNotFinite:
      return "SAMPLE_NOT_FINITE";
    case Fault::kSampleOutOfRange:
      return "SAMPLE_OUT_OF_RANGE";
    case Fault::kLoopLate:
      return "LOOP_LATE";
    case Fault::kLateBucketFull:
      return "LATE_BUCKET_FULL";
    case Fault::kEmergencyStop:
      return "EMERGENCY_STOP";
    case Fault::kForceOverLimit:
      return "FORCE_OVER_LIMIT";
    case Fault::kOutputNotFinite:
      return "OUTPUT_NOT_FINITE";
  }
  return "UNKNOWN_FAULT";
}

std::string_view reason(Limiter limiter) noexcept {
  switch (limiter) {
    case Limiter::kSaturation:
      return "SATURATION";
    case Limiter::kSlew:
      return "SLEW";
    case Limiter::kEnvelope:
      return "ENVELOPE";
    case Limiter::kDirectionGuard:
      return "DIRECTION_GUARD";
    case Limiter::kRangeClamp:
      return "RANGE_CLAMP";
    case Limiter::kEnergyTank:
      return "ENERGY_TANK";
    case Limiter::kPassivity:
      return "PASSIVITY";
    case Limiter::kInfeasiblePlanes:
      return "INFEASIBLE_PLANES";
    case Limiter::kMonotoneEnvelope:
      return "MONOTONE_ENVELOPE";
    case Limiter::kPower:
      return "POWER";
    case Limiter::kRate:
      return "RATE";
    case Limiter::kTemperature:
      return "TEMPERATURE";
    case Limiter::kDriveLimit:
      return "DRIVE_LIMIT";
  }
  return "UNKNOWN_LIMITER";
}

}  // namespace haptic::core
