#include "hw/motion/pchip.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace haptic::hw {
namespace {

bool same_sign(double a, double b) {
  return (a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0);
}

/// Slope at an inner knot between intervals of length h0, h1 and secants d0, d1: 0 at an extremum,
/// elsewhere their harmonic mean, the nearer secant weighing more.
double inner_slope(double h0, double h1, double d0, double d1) {
  if (!same_sign(d0, d1)) return 0.0;
  const double w0 = 2.0 * h1 + h0;
  const double w1 = h1 + 2.0 * h0;
  return (w0 + w1) / (w0 / d0 + w1 / d1);
}

/// Slope at an end: the parabola through the three knots nearest to it, held to what keeps the
/// first interval monotone.
double end_slope(double h0, double h1, double d0, double d1) {
  const double parabola = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
  if (!same_sign(parabola, d0)) return 0.0;
  if (!same_sign(d0, d1) && std::abs(parabola) > 3.0 * std::abs(d0)) return 3.0 * d0;
  return parabola;
}

}  // namespace

Pchip::Pchip(std::vector<double> t, std::vector<double> y)
    : t_(std::move(t)), y_(std::move(y)), slope_(t_.size(), 0.0) {
  assert(!t_.empty() && t_.size() == y_.size());
  const std::size_t n = t_.size();
  const auto h = [&](std::size_t i) { return t_[i + 1] - t_[i]; };
  const auto secant = [&](std::size_t i) { return (y_[i + 1] - y_[i]) / h(i); };
  if (n == 2) slope_[0] = slope_[1] = secant(0);
  if (n <= 2) return;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    slope_[i] = inner_slope(h(i - 1), h(i), secant(i - 1), secant(i));
  }
  slope_[0] = end_slope(h(0), h(1), secant(0), secant(1));
  slope_[n - 1] = end_slope(h(n - 2), h(n - 3), secant(n - 2), secant(n - 3));
}

std::size_t Pchip::interval(double at) const noexcept {
  const auto above = std::upper_bound(t_.begin() + 1, t_.end() - 1, at);
  return static_cast<std::size_t>(above - t_.begin()) - 1;
}

Pchip::Place Pchip::place(double at) const noexcept {
  if (!(at > t_.front())) return {};
  if (at >= t_.back()) return {t_.size() - 1};
  const std::size_t i = interval(at);
  const double h = t_[i + 1] - t_[i];
  return {i, h, (at - t_[i]) / h};
}

double Pchip::operator()(const Place& place) const noexcept {
  const std::size_t i = place.interval;
  const double h = place.length, u = place.share;
  if (u == 0.0) return y_[i];
  const double rise = y_[i + 1] - y_[i];
  const double a = h * slope_[i];
  const double b = h * slope_[i + 1];
  return y_[i] + u * (a + u * ((3.0 * rise - 2.0 * a - b) + u * (a + b - 2.0 * rise)));
}

}  // namespace haptic::hw
