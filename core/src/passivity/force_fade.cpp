#include "haptic/core/passivity/force_fade.hpp"

namespace haptic::core {

const VecA& EasedForce::step(const VecA& wish, const VecA& allowed, const VecA& limit,
                             double tick) noexcept {
  constexpr double kNear = 0.1;  // of a step: that is there
  whole_ = true;
  for (Eigen::Index i = 0; i < wish.size(); ++i) {
    // It may hold back as much as before, stay, or go by itself: the nearest to the allowed counts.
    const double kept = used_[i] + (wish[i] - wish_[i]);
    const double same = std::clamp(used_[i], std::min(0.0, wish[i]), std::max(0.0, wish[i]));
    const double with_wish = std::clamp(allowed[i], std::min(kept, same), std::max(kept, same));
    const double most = limit[i] * tick / ForceFade::kWhole_s;
    const double way = (allowed[i] - used_[i]) * std::min(1.0, tick / kSmooth_s);
    const double alone = used_[i] + std::clamp(way, -most, most);
    double force =
        std::abs(allowed[i] - alone) < std::abs(allowed[i] - with_wish) ? alone : with_wish;
    if (!(std::abs(allowed[i] - force) > kNear * most)) force = allowed[i];
    const auto [least, largest] = std::minmax({0.0, wish[i], allowed[i]});
    used_[i] = std::clamp(force, least, largest);
    whole_ = whole_ && used_[i] == wish[i] && allowed[i] == wish[i];
  }
  wish_ = wish;
  if (!used_.allFinite()) restart();
  return used_;
}

}  // namespace haptic::core
