// The gradients of the contacts, of unit length in W^-1, as they are told and where curved gaps are
// linearised. In a hand of many outputs a contact names few coordinates of many: what is done with
// gradients is done with those alone.
#include <algorithm>
#include <bit>
#include <cmath>

#include "haptic/core/contacts/plane_projection.hpp"

namespace haptic::core {

void PlaneProjection::take(const PlaneSet& planes, int i) noexcept {
  beta_[i] = gamma_[i] = speed_[i] = 0.0;
  const double gamma = soft_ ? planes.compliance[i] : 0.0;
  double speed = moving_ ? planes.velocity[i] : 0.0;
  scale_[i] = 1.0;
  auto H = H_.segment(begin_[static_cast<std::size_t>(i)],
                      PlaneSet::triangle(n_curved_[static_cast<std::size_t>(i)]));
  const bool usable = gamma >= 0.0 && std::isfinite(gamma) && std::isfinite(speed) &&
                      (planes.laws.cols() == 0 || planes.laws.col(i).allFinite()) && H.allFinite();
  if (metric_.is_identity()) {
    contacts_.into.col(i) = A_.col(i);
  } else {
    contacts_.into.col(i) = metric_.steepest(A_.col(i));
  }
  find_rows(i);
  const double length = usable ? normalise(i) : 0.0;
  if (length == 0.0) {
    skipped_ |= 1u << i;
    A_.col(i).setZero();
    contacts_.into.col(i).setZero();
    return;
  }
  laws_.take(planes.laws, i, speed, length, planes.ids.size() > 0 ? planes.ids[i] : 0.0);
  if (laws_.has(i)) speed = 0.0;
  beta_[i] = planes.offsets[i] / length - along(i, at_.data());
  gamma_[i] = gamma / (length * length);
  if (gamma_[i] < ContactDual::kEpsilon) gamma_[i] = 0.0;
  speed_[i] = speed / length;
  if (H.isZero(0.0)) return;
  H /= length;
  curved_ |= 1u << i;
}

void PlaneProjection::find_rows(int i) noexcept {
  const auto at = static_cast<std::size_t>(i);
  const double* const normal = A_.col(i).data();
  const auto names = [](double entry) { return entry != 0.0; };
  int end = static_cast<int>(A_.rows());
  int first = static_cast<int>(std::find_if(normal, normal + end, names) - normal);
  while (end > first && normal[end - 1] == 0.0) --end;
  if (n_curved_[at] > 0) {
    first = std::min<int>(first, first_[at]);
    end = std::max<int>(end, first_[at] + n_curved_[at]);
  }
  rows_[at] = {first, end - first};
}

double PlaneProjection::along(int i, const double* v) const noexcept {
  const double* const normal = A_.col(i).data();
  const Rows rows = rows_of(i);
  double sum = 0.0;
  for (int k = rows.first; k < rows.first + rows.count; ++k) sum += normal[k] * v[k];
  return sum;
}

double PlaneProjection::normalise(int i) noexcept {
  PlaneSet::Normals& D = contacts_.into;
  const double length = std::sqrt(along(i, D.col(i).data()));
  if (!(length > 0.0) || !std::isfinite(length)) return 0.0;
  const Rows a = rows_of(i), d = rows_into(i);
  A_.col(i).segment(a.first, a.count) /= length;
  D.col(i).segment(d.first, d.count) /= length;
  return length;
}

void PlaneProjection::multiply(int i, int j) noexcept {
  ContactDual::Gram& products = dual_.products();
  products(i, j) = products(j, i) = along(i, contacts_.into.col(j).data());
}

void PlaneProjection::fill_diagonal(int i) noexcept {
  const double gives = laws_.any() ? laws_.give(i) * scale_[i] * scale_[i] : 0.0;
  dual_.set_diagonal(i, dual_.products()(i, i), gamma_[i] + gives);
}

void PlaneProjection::fill_gram() noexcept {
  dual_.give(laws_.any() ? laws_.gives(scale_) : ContactDual::Gives{});
  for (int i = 0; i < count_; ++i) fill_diagonal(i);
}

/// Two fingers of a hand move other coordinates: their contacts' products stay 0.
void PlaneProjection::find_meeting(int i) noexcept {
  const Rows a = rows_of(i);
  std::uint32_t& meeting = meeting_[static_cast<std::size_t>(i)];
  meeting = 0;
  for (int j = 0; j <= i; ++j) {
    if (meet(a, rows_into(j))) meeting |= 1u << j;
  }
}

void PlaneProjection::linearise() noexcept {
  for (int i = 0; i < count_; ++i) {
    if (!ContactDual::has(curved_, i)) continue;
    const int first = first_[static_cast<std::size_t>(i)];
    const int n = n_curved_[static_cast<std::size_t>(i)];
    const Rows a = rows_of(i), d = rows_into(i);
    turn_.segment(a.first, a.count).setZero();
    const double* entry = H_.data() + begin_[static_cast<std::size_t>(i)];
    for (int row = 0; row < n; ++row) {
      for (int column = 0; column <= row; ++column, ++entry) {
        turn_[first + row] += *entry * z_[first + column];
        if (column < row) turn_[first + column] += *entry * z_[first + row];
      }
    }
    const auto turn = turn_.segment(first, n);
    if (!metric_.is_identity()) into_ = metric_.steepest(turn_, first, n);
    const VecX& into = metric_.is_identity() ? turn_ : into_;
    const double turned = std::sqrt(turn.dot(into.segment(first, n)));
    const double share = turned > kMostTurn ? kMostTurn / turned : 1.0;
    A_.col(i).segment(a.first, a.count) =
        told_.col(i).segment(a.first, a.count) - share * turn_.segment(a.first, a.count);
    contacts_.into.col(i).segment(d.first, d.count) =
        told_into_.col(i).segment(d.first, d.count) - share * into.segment(d.first, d.count);
    const double length = normalise(i);
    const double scale = length > 0.0 ? 1.0 / length : 0.0;
    beta_[i] = (told_beta_[i] - 0.5 * share * share * turn.dot(z_.segment(first, n))) * scale;
    gamma_[i] = told_gamma_[i] * scale * scale;
    speed_[i] = told_speed_[i] * scale;
    scale_[i] = scale;
  }
  for (int i = 0; i < count_; ++i) {
    std::uint32_t pairs = meeting_[static_cast<std::size_t>(i)];
    if (!ContactDual::has(curved_, i)) pairs &= curved_;
    for (; pairs != 0; pairs &= pairs - 1) multiply(i, std::countr_zero(pairs));
  }
  fill_gram();
}

}  // namespace haptic::core
