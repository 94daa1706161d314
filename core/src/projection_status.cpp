#include "haptic/core/projection_status.hpp"

namespace haptic::core {

std::string_view name(ProjectionStatus status) noexcept {
  switch (status) {
    case ProjectionStatus::kNone:
      return "NONE";
    case ProjectionStatus::kExact:
      return "EXACT";
    case ProjectionStatus::kConverged:
      return "CONVERGED";
    case ProjectionStatus::kCapped:
      return "CAPPED";
    case ProjectionStatus::kUnreachable:
      return "UNREACHABLE";
    case ProjectionStatus::kIllConditioned:
      return "ILL_CONDITIONED";
    case ProjectionStatus::kRankDeficient:
      return "RANK_DEFICIENT";
    case ProjectionStatus::kMapFailed:
      return "MAP_FAILED";
  }
  return "UNKNOWN";
}

}  // namespace haptic::core
