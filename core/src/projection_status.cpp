#include "haptic/core/projection_status.hpp"

#include "haptic/core/names.hpp"

namespace haptic::core {

std::string_view name(ProjectionStatus status) noexcept {
  static constexpr std::array<std::string_view, 8> kNames{
      "NONE",        "EXACT",           "CONVERGED",      "CAPPED",
      "UNREACHABLE", "ILL_CONDITIONED", "RANK_DEFICIENT", "MAP_FAILED"};
  return name_of(status, kNames);
}

}  // namespace haptic::core
