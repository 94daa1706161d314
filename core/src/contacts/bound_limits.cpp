// When the error bound is not known: contacts that meet at too small an angle, and another minimum
// of the proxy's problem (core/METHOD.md#error-bound).
#include <algorithm>
#include <cmath>

#include "haptic/core/contacts/proxy_bound.hpp"

namespace haptic::core {

namespace {

constexpr double kNarrow = 0.8660254037844386;  // cosine of 30 degrees
constexpr double kStiff = 1.0 / 16.0;           // gamma below which kWedge counts

}  // namespace

/// Errors of two stiff gaps move the edge between them by much more, if they meet at less than
/// kWedge is for.
bool ProxyBound::wedged(const Open& open) const noexcept {
  for (int i = 0; i < gaps_.size() && !open.few; ++i) {
    if (open.gap[i] <= open.room[i] || gaps_.gamma()[i] > kStiff) continue;
    for (int j = 0; j < gaps_.size(); ++j) {
      if (j == i || gaps_.leaves_out(j) || gaps_.gamma()[j] > kStiff) continue;
      if (solver_.l()[j] == 0.0 && open.gap[j] <= open.room[j]) continue;
      const double cosine = gaps_.gradients().col(i).dot(gaps_.contacts().into.col(j));
      if (std::abs(cosine) > kNarrow) return true;
    }
  }
  return false;
}

/// Round bodies of a point: the sums of l_i ||H_i|| of two minima are 2 or more together. None is
/// further from the probe than `most`, and none stores more, which bounds the other's sum.
bool ProxyBound::only_minimum(const Open& open, const Remainder* left) const noexcept {
  VecX pushed = VecX::Zero(gaps_.space().n_x());
  for (int i = 0; i < gaps_.size(); ++i) {
    if (solver_.l()[i] > 0.0) gaps_.push(pushed, solver_.l()[i], i);
  }
  double square = 0.0;
  for (int i = 0; i < gaps_.size(); ++i) {
    const double l = solver_.l()[i];
    if (l > 0.0) square += l * (gaps_.along(i, pushed.data()) + gaps_.gamma()[i] * l);
  }
  const double most = std::sqrt(square);
  double sharpest = 0.0, square_sum = 0.0;
  int near = 0;
  for (int i = 0; i < gaps_.size(); ++i) {
    if (gaps_.leaves_out(i) || gaps_.contacts().depth[i] < -most) continue;
    const double gamma = gaps_.gamma()[i];
    ++near;
    if (!gaps_.is_curved(i)) continue;
    if (round_[static_cast<std::size_t>(i)].moves() == RoundGap::Moves::kHinges) return true;
    const double radius = 1.0 / (gaps_.scale()[i] * left[i].bend);
    const double least =
        std::max(radius - 2.0 * most, radius + gamma * solver_.l()[i] - std::sqrt(gamma) * most);
    const double sharp = least > 0.0 ? 1.0 / least : HUGE_VAL;
    sharpest = std::max(sharpest, sharp);
    square_sum += gamma > 0.0 ? sharp * sharp / gamma : HUGE_VAL;
  }
  return near < 2 || open.bent + std::min(kWedge * sharpest, std::sqrt(square_sum)) * most < 2.0;
}

}  // namespace haptic::core
