#include "haptic/core/contacts/round_gap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::core {

namespace {

/// Share of the second order: a client's arithmetic leaves less than that of 0.
constexpr double kToldZero = 1e-6;
/// Least difference from which hinges and body are found: less is little above a client's
/// arithmetic.
constexpr double kLeastApart = 1e-3;
/// Share of the body's radius: nearer to its centre no normal is known.
constexpr double kCentre = 1e-3;
constexpr double kSphere = 1.1547005383792517;  // 2 / sqrt(3)
/// Part of a way that, times a finger's reach and curve, is 1: the fourth order is known on it.
constexpr double kShortest = 15.0;

/// Across the body's normal, as its tangent points, and along it.
struct Pair {
  double across, along;
  [[nodiscard]] Pair turned(double cosine, double sine) const noexcept {
    return {across * cosine + along * sine, along * cosine - across * sine};
  }
};

/// From a round body, after a way along its normal, and one across of which curve times the square
/// is `curved`.
struct Distance {
  Distance(double curve, double along, double curved) noexcept
      : u(1.0 + curve * along),
        root(std::max(kCentre, std::sqrt(u * u + std::max(0.0, curve * curved)))),
        gap(u > 0.0 ? along + curved / (u + root) : (root - 1.0) / curve) {}
  double u, root;  ///< from the centre, by the radius: along the normal, and in all
  double gap;
};

}  // namespace

RoundGap::RoundGap(Moves moves, int n, const double* g, const double* H) noexcept : n_(n) {
  double square = 0.0;
  for (int i = 0; i < n; ++i) square += g[i] * g[i];
  length_ = std::sqrt(square);
  for (int i = 0; i < n; ++i) {
    g_[i] = g[i] / length_;
    for (int j = 0; j <= i; ++j) H_[i][j] = H_[j][i] = *H++ / length_;
  }
  if (moves == Moves::kHinges && !find_height()) return;
  curve_ = moves == Moves::kHinges ? curve_of_hinges() : curve_of_point();
  place(moves);
}

/// A distance does not turn its gradient along itself, and a round body turns it at one rate in
/// each direction in which it curves.
double RoundGap::curve_of_point() const noexcept {
  double most = 0.0, trace = 0.0, square = 0.0, cube = 0.0, along = 0.0;
  for (int i = 0; i < n_; ++i) {
    trace += H_[i][i];
    double Hg = 0.0;
    for (int j = 0; j < n_; ++j) {
      most = std::max(most, std::abs(H_[i][j]));
      square += H_[i][j] * H_[i][j];
      Hg += H_[i][j] * g_[j];
      for (int k = 0; k < n_; ++k) cube += H_[i][j] * H_[j][k] * H_[k][i];
    }
    along = std::max(along, std::abs(Hg));
  }
  const bool round = along <= kToldZero * most &&
                     std::abs(trace * cube - square * square) <= kToldZero * square * square;
  return round ? square / trace : std::numeric_limits<double>::quiet_NaN();
}

/// With h_k the point's height above hinge k: H_jk = h_k (curve h_j - 1) for j <= k.
bool RoundGap::find_height() noexcept {
  const double most = std::max({std::abs(H_[0][0]), std::abs(H_[0][1]), std::abs(H_[1][1])});
  const double apart = H_[0][0] - H_[0][1];
  if (!(std::abs(apart) > kLeastApart * most)) return false;
  height_[1] = (H_[0][1] * H_[0][1] - H_[0][0] * H_[1][1]) / apart;
  return std::abs(height_[1]) > kLeastApart;
}

double RoundGap::curve_of_hinges() const noexcept {
  return (1.0 + H_[1][1] / height_[1]) / height_[1];
}

void RoundGap::place(Moves moves) noexcept {
  if (moves == Moves::kHinges) {
    const double rolls = H_[0][1] / height_[1];  // curve h_1 - 1
    height_[0] = rolls > -0.5 ? (1.0 + rolls) / curve_ : H_[0][0] / rolls;
    const double near = std::hypot(g_[1], height_[1]);
    link_ = std::hypot(g_[0] - g_[1], height_[0] - height_[1]);
    reach_ = std::hypot(link_ + near, near);
  }
  if (std::isfinite(curve_) && std::isfinite(reach_)) moves_ = moves;
}

RoundGap::Turn::Turn(const double* z) noexcept
    : cosine{std::cos(z[0]), std::cos(z[0] + z[1])}, sine{std::sin(z[0]), std::sin(z[0] + z[1])} {}

RoundGap::Off RoundGap::point(const double* z, const Law& law) const noexcept {
  double along = 0.0, curved = 0.0;
  double Hz[kMost]{};
  for (int i = 0; i < n_; ++i) {
    along += g_[i] * z[i];
    for (int j = 0; j < n_; ++j) Hz[i] += H_[i][j] * z[j];
    curved += Hz[i] * z[i];
  }
  const Distance d(curve_, along, curved);
  double square = 0.0;
  for (int i = 0; i < n_; ++i) {
    const double off = (d.u * g_[i] + Hz[i]) / d.root - law.gradient[i] / length_;
    square += off * off;
  }
  const double curve = std::abs(curve_) / (d.root * length_);
  // |T(v, v, .)| <= 2 / sqrt(3) curve^2, where curve is at most twice what it is here: 6 times
  // curve is the slope of the chord of curve^2 until there.
  return {.gap = std::abs(d.gap * length_ - law.gap),
          .gradient = std::sqrt(square),
          .bend = curve,
          .third = kSphere * curve * curve,
          .fourth = 6.0 * kSphere * curve * curve * curve,
          .grows = 2.0 * curve};
}

/// Places the chain with its links turned, and takes the distance there.
RoundGap::Off RoundGap::hinges(const Turn& turn, const Law& law) const noexcept {
  const Pair over_1{-g_[0], height_[0]}, over_2{-g_[1], height_[1]};  // the point from each hinge
  const Pair link{over_1.across - over_2.across, over_1.along - over_2.along};
  const Pair base = link.turned(turn.cosine[0], turn.sine[0]);
  const Pair end = over_2.turned(turn.cosine[1], turn.sine[1]);
  const Pair over[]{{base.across + end.across, base.along + end.along}, end};
  const double across = over[0].across - over_1.across, along = over[0].along - over_1.along;
  const Distance d(curve_, along, curve_ * across * across);
  const Pair normal{curve_ * across / d.root, d.u / d.root};
  double square = 0.0, slope[2], height[2];
  for (int j = 0; j < 2; ++j) {
    slope[j] = normal.across * over[j].along - normal.along * over[j].across;
    height[j] = normal.across * over[j].across + normal.along * over[j].along;
    const double off = slope[j] - law.gradient[j] / length_;
    square += off * off;
  }
  const double curve = curve_ / d.root;
  const double rolls = curve * height[0] - 1.0;
  const double H_11 = height[0] * rolls, H_12 = height[1] * rolls;
  const double H_22 = height[1] * (curve * height[1] - 1.0), apart = H_11 - H_22;
  // core/METHOD.md#error-bound
  const double a = curve * height[0], b = curve * height[1];
  const double T_111 = slope[0] * (3.0 * a * (1.0 - a) - 1.0);
  const double T_112 = slope[1] * (2.0 * a - a * a - 1.0) + slope[0] * b * (1.0 - 2.0 * a);
  const double T_122 = slope[1] * (2.0 * b + a - 2.0 * a * b - 1.0) - slope[0] * b * b;
  const double T_222 = slope[1] * (3.0 * b * (1.0 - b) - 1.0);
  const double grows = std::abs(curve) * reach_, more = 1.0 + grows;
  return {
      .gap = std::abs(d.gap * length_ - law.gap),
      .gradient = std::sqrt(square),
      .bend =
          0.5 * (std::abs(H_11 + H_22) + std::sqrt(apart * apart + 4.0 * H_12 * H_12)) / length_,
      .third = std::sqrt(T_111 * T_111 + 3.0 * (T_112 * T_112 + T_122 * T_122) + T_222 * T_222) /
               (length_ * length_),
      .fourth = 5.0 * reach_ * more * more * more / (length_ * length_ * length_),
      .grows = kShortest * grows / length_};
}

}  // namespace haptic::core
