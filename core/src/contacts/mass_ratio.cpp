#include "haptic/core/contacts/mass_ratio.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

/// Time constant of forgetting while the object moves, s.
constexpr double kForgets_s = 0.4;
/// Weight of what the ratio does not explain: an untold force may go on for as long as is
/// remembered, unlike noise, which many samples average out.
constexpr double kUnexplained = 100.0;

}  // namespace

void MassRatio::learn(const Seen& seen, double s) noexcept {
  const double all = seen.square + seen.floor;
  const double share = all > 0.0 ? seen.square / all : 0.0;
  if (!(share > 0.0) || !std::isfinite(all) || !std::isfinite(seen.told)) return;
  const double kept = std::exp(-share * s / kForgets_s);
  sum_ = {kept * sum_.square + share * seen.square, kept * sum_.product + share * seen.product,
          kept * sum_.told + share * seen.told, kept * sum_.floor + share * seen.floor};
  const double unexplained = sum_.told - sum_.product * sum_.product / sum_.square;
  const double doubt = sum_.floor + kUnexplained * std::max(0.0, unexplained);
  const double ratio = (sum_.product + doubt) / (sum_.square + doubt);
  if (std::isfinite(ratio)) value_ = std::clamp(ratio, 1.0 / kMost, kMost);
}

}  // namespace haptic::core
