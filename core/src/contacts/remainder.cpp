// How far a gap may be from what its gradient and curvature say (core/METHOD.md#error-bound).
#include <algorithm>
#include <cmath>

#include "haptic/core/contacts/proxy_bound.hpp"

namespace haptic::core {

namespace {

/// Two links are the same if their lengths differ by less than this share. A client's arithmetic
/// leaves less; another finger or body makes more.
constexpr double kSameLink = 1e-3;
constexpr double kNothingKnown = 1e9;

/// A joint that is not said to turn without end is on the real line, in rad.
bool turns_points(const Coordinate& c) noexcept {
  return c.unit == Unit::kRadian || c.kind != CoordinateKind::kLinear;
}

}  // namespace

/// sqrt(tr(H W^-1 H W^-1)).
double ProxyBound::bend(int i) const noexcept {
  const auto [first, n, begin] = gaps_.curve(i);
  const double* lower = gaps_.curvature(i);
  const auto entry = [lower](int row, int column) {
    const int most = std::max(row, column);
    return lower[PlaneSet::triangle(most) + std::min(row, column)];
  };
  Eigen::Matrix<double, kMaxCurved, kMaxCurved> P;
  VecX column_of(gaps_.space().n_x());
  for (int column = 0; column < n; ++column) {
    column_of.setZero();
    for (int row = 0; row < n; ++row) column_of[first + row] = entry(row, column);
    P.col(column).head(n) = gaps_.metric().steepest(column_of, first, n).segment(first, n);
  }
  double square = 0.0;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) square += P(row, column) * P(column, row);
  }
  return std::sqrt(std::max(0.0, square));
}

/// The contact's coordinates are those of a point, or of two parallel hinges. Any two joints fit
/// some such finger, and so does a body that lies off the plane in which the finger moves. Such a
/// fit has another link than the one that is known, and is rejected by it.
RoundGap ProxyBound::round_gap(const PlaneSet& told, int i) const noexcept {
  const auto [first, n, begin] = gaps_.curve(i);
  const TaskMetric& metric = gaps_.metric();
  const bool alike =
      metric.is_identity() || (metric.separates(first, n) && metric.is_uniform(first, n));
  if (n < 2 || n > RoundGap::kMost || gaps_.breadth(i) > n || !alike) return {};
  const auto& coordinates = gaps_.space().coordinates();
  const double link = coordinates[static_cast<std::size_t>(first)].link;
  const bool hinges = n == 2 && link > 0.0;
  for (int k = first; k < first + n && !hinges; ++k) {
    if (turns_points(coordinates[static_cast<std::size_t>(k)])) return {};
  }
  const auto moves = hinges ? RoundGap::Moves::kHinges : RoundGap::Moves::kPoint;
  const VecX g = -gaps_.gradients().col(i);
  const double* const H = gaps_.curvature(i);
  const RoundGap gap(moves, n, g.data() + first, H);
  const double scale = told.normals.col(i).norm() / gap.length();
  const bool fits = !hinges || std::abs(scale * gap.link() - link) < kSameLink * link;
  return fits ? gap : RoundGap{};
}

/// For a round body: the remainder at x itself. For other bodies a bound: if a point meets a body
/// of constant curvature 1/R, the third derivative of the gap along z is 3 z_n z_t^2 / R^2; planar
/// joints add 3 of the gradient and of H per angle. A contact without curvature is taken as flat.
ProxyBound::Remainder ProxyBound::remainder(int i, LastTurn& last) const noexcept {
  const auto [first, n, begin] = gaps_.curve(i);
  const double* const z = solver_.at().data() + first;
  const RoundGap& round = round_[static_cast<std::size_t>(i)];
  if (round.moves() == RoundGap::Moves::kUnknown) return of_any_shape(i, z);
  // The law is the plane that is in use.
  double gradient[RoundGap::kMost];
  const double scale = gaps_.scale()[i];
  for (int k = 0; k < n; ++k) gradient[k] = -gaps_.gradients()(first + k, i) / scale;
  const double gap = (gaps_.beta()[i] - gaps_.along(i, solver_.at().data())) / scale;
  const RoundGap::Law law{gap - gaps_.told_beta()[i], gradient};
  if (round.moves() == RoundGap::Moves::kPoint) return round.point(z, law);
  if (last.first != first) last = {first, RoundGap::Turn(z)};
  return round.hinges(last.turn, law);
}

ProxyBound::Remainder ProxyBound::of_any_shape(int i, const double* z) const noexcept {
  const auto [first, n, begin] = gaps_.curve(i);
  const double* entry = gaps_.curvature(i);
  const double* const g = gaps_.told_gradients().col(i).data() + first;
  double turns = 0.0, along = 0.0, most_along = 0.0, bent = 0.0, most_bent = 0.0;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column <= row; ++column, ++entry) {
      const double twice = (column < row ? 2.0 : 1.0) * *entry * z[column] * z[row];
      bent += twice;
      most_bent += std::abs(twice);
    }
    if (turns_points(gaps_.space().coordinates()[static_cast<std::size_t>(first + row)])) {
      turns += std::abs(z[row]);
    }
    most_along += std::abs(g[row] * z[row]);
    along -= g[row] * z[row];
  }
  VecX scratch;
  const TaskMetric& metric = gaps_.metric();
  const double far = metric.is_identity() ? solver_.at().segment(first, n).norm()
                                          : metric.weighed(solver_.at(), scratch).norm();
  const double turned = bend_[i] * far;
  if (turned > kMostBent) return {kNothingKnown, kNothingKnown, kNothingKnown};
  const double left = 1.0 - turned;
  const double curve = 0.5 * (std::abs(along) + std::abs(bent)) * turned * turned / (left * left);
  const double tilt = 0.5 * turned * (turned + 2.0 * bend_[i] * std::abs(along)) / (left * left);
  // The plane that is in use touches the law a little way from x.
  const double off = bend_[i] * solver_.unsettled();
  return {curve + 0.5 * turns * (turns * most_along + most_bent) + 0.5 * off * solver_.unsettled(),
          tilt + 1.5 * turns * (turns + turned) + off, bend_[i] / left};
}

}  // namespace haptic::core
