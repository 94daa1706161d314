// In a hand of many outputs a contact names few coordinates of many: what is done with gradients is
// done with those alone.
#include "haptic/core/contacts/contact_gaps.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace haptic::core {

ContactGaps::ContactGaps(const ConfigurationSpace& space, TaskMetric metric)
    : space_(&space), metric_(std::move(metric)), at_(VecX::Zero(space.n_x())) {
  for (const Coordinate& c : space.coordinates()) {
    linear_.push_back(c.kind == CoordinateKind::kLinear);
  }
}

void ContactGaps::set(const PlaneSet& told, const VecX& x) noexcept {
  count_ = told.size();
  left_out_ = curved_ = 0;
  moving_ = told.velocity.size() > 0;
  at_ = x;
  A_ = told.normals;
  H_ = told.curvature;
  contacts_.into.resize(A_.rows(), count_);
  contacts_.depth.setConstant(count_, -1.0);
  int begin = 0;
  for (int i = 0; i < count_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    curve_[at] = {told.first[at], told.curved[at], begin};
    begin += PlaneSet::triangle(told.curved[at]);
    take(told, i);
    find_meeting(i);
  }
}

void ContactGaps::take(const PlaneSet& told, int i) noexcept {
  beta_[i] = gamma_[i] = speed_[i] = 0.0;
  scale_[i] = 1.0;
  const double gamma = told.compliance.size() > 0 ? told.compliance[i] : 0.0;
  const double speed = moving_ ? told.velocity[i] : 0.0;
  auto H = H_.segment(curve(i).begin, PlaneSet::triangle(curve(i).count));
  const bool usable = gamma >= 0.0 && std::isfinite(gamma) && std::isfinite(speed) &&
                      (told.laws.cols() == 0 || told.laws.col(i).allFinite()) && H.allFinite();
  if (metric_.is_identity()) {
    contacts_.into.col(i) = A_.col(i);
  } else {
    contacts_.into.col(i) = metric_.steepest(A_.col(i));
  }
  find_rows(i);
  const double length = length_[i] = usable ? normalise(i) : 0.0;
  if (length == 0.0) {
    left_out_ |= 1u << i;
    A_.col(i).setZero();
    contacts_.into.col(i).setZero();
    return;
  }
  beta_[i] = told.offsets[i] / length - along(i, at_.data());
  gamma_[i] = gamma / (length * length);
  if (gamma_[i] < ContactDual::kEpsilon) gamma_[i] = 0.0;
  speed_[i] = speed / length;
  if (H.isZero(0.0)) return;
  H /= length;
  curved_ |= 1u << i;
}

void ContactGaps::find_rows(int i) noexcept {
  const double* const normal = A_.col(i).data();
  const auto names = [](double entry) { return entry != 0.0; };
  int end = static_cast<int>(A_.rows());
  int first = static_cast<int>(std::find_if(normal, normal + end, names) - normal);
  while (end > first && normal[end - 1] == 0.0) --end;
  if (const Curve& curve = this->curve(i); curve.count > 0) {
    first = std::min(first, curve.first);
    end = std::max(end, curve.first + curve.count);
  }
  rows_[static_cast<std::size_t>(i)] = {first, end - first};
}

/// Two fingers of a hand move other coordinates: their contacts' products stay 0.
void ContactGaps::find_meeting(int i) noexcept {
  std::uint32_t& meeting = meeting_[static_cast<std::size_t>(i)] = 0;
  for (int j = 0; j <= i; ++j) {
    if (rows_of(i).meet(rows_into(j))) meeting |= 1u << j;
  }
}

double ContactGaps::normalise(int i) noexcept {
  PlaneSet::Normals& D = contacts_.into;
  const double length = std::sqrt(along(i, D.col(i).data()));
  if (!(length > 0.0) || !std::isfinite(length)) return 0.0;
  const Rows a = rows_of(i), d = rows_into(i);
  A_.col(i).segment(a.first, a.count) /= length;
  D.col(i).segment(d.first, d.count) /= length;
  return length;
}

void ContactGaps::keep() noexcept {
  if (curved_ == 0) return;
  told_.A.resize(A_.rows(), count_);
  told_.into.resize(A_.rows(), count_);
  for (std::uint32_t left = curved_; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    told_.A.col(i) = A_.col(i);
    told_.into.col(i) = contacts_.into.col(i);
  }
  told_.beta = beta_;
  told_.gamma = gamma_;
  told_.speed = speed_;
  turn_.setZero(at_.size());
}

void ContactGaps::linearise(const VecX& z) noexcept {
  for (std::uint32_t left = curved_; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const auto [first, n, begin] = curve(i);
    const Rows a = rows_of(i), d = rows_into(i);
    turn_.segment(a.first, a.count).setZero();
    const double* entry = H_.data() + begin;
    for (int row = 0; row < n; ++row) {
      for (int column = 0; column <= row; ++column, ++entry) {
        turn_[first + row] += *entry * z[first + column];
        if (column < row) turn_[first + column] += *entry * z[first + row];
      }
    }
    const auto turn = turn_.segment(first, n);
    if (!metric_.is_identity()) into_ = metric_.steepest(turn_, first, n);
    const VecX& into = metric_.is_identity() ? turn_ : into_;
    const double turned = std::sqrt(turn.dot(into.segment(first, n)));
    const double share = turned > kMostTurn ? kMostTurn / turned : 1.0;
    A_.col(i).segment(a.first, a.count) =
        told_.A.col(i).segment(a.first, a.count) - share * turn_.segment(a.first, a.count);
    contacts_.into.col(i).segment(d.first, d.count) =
        told_.into.col(i).segment(d.first, d.count) - share * into.segment(d.first, d.count);
    const double length = normalise(i);
    const double scale = scale_[i] = length > 0.0 ? 1.0 / length : 0.0;
    beta_[i] = (told_.beta[i] - 0.5 * share * share * turn.dot(z.segment(first, n))) * scale;
    gamma_[i] = told_.gamma[i] * scale * scale;
    speed_[i] = told_.speed[i] * scale;
  }
}

double ContactGaps::along(int i, const double* v) const noexcept {
  const double* const normal = A_.col(i).data();
  const Rows rows = rows_of(i);
  double sum = 0.0;
  for (int k = rows.first; k < rows.first + rows.count; ++k) sum += normal[k] * v[k];
  return sum;
}

void ContactGaps::push(VecX& v, double l, int i) const noexcept {
  const Rows rows = rows_into(i);
  const double* const into = contacts_.into.col(i).data();
  for (int k = rows.first; k < rows.first + rows.count; ++k) v[k] += l * into[k];
}

double ContactGaps::violations(const VecX& y, double age, const ContactLaws& laws,
                               Vector& r) noexcept {
  double deepest = 0.0;
  for (int i = 0; i < count_; ++i) {
    const bool out = ContactDual::has(left_out_, i);
    r[i] = out ? -1.0 : along(i, y.data()) - beta_[i];
    if (moving_ && !out) r[i] -= age * speed_[i];
    if (laws.has(i)) r[i] -= laws.free(i) * scale_[i];
    deepest = std::max(deepest, r[i]);
    contacts_.depth[i] = r[i];
  }
  return deepest;
}

void ContactGaps::multiply(std::uint32_t changed, ContactDual::Gram& products) const noexcept {
  for (int i = 0; i < count_; ++i) {
    std::uint32_t pairs = meeting_[static_cast<std::size_t>(i)];
    if (!ContactDual::has(changed, i)) pairs &= changed;
    for (; pairs != 0; pairs &= pairs - 1) {
      const int j = std::countr_zero(pairs);
      products(i, j) = products(j, i) = along(i, contacts_.into.col(j).data());
    }
  }
}

void ContactGaps::displace(const VecX& y, const Vector& l, std::uint32_t held,
                           VecX& x) const noexcept {
  if (held == 0) return;
  bool moved[kMaxX];
  for (Eigen::Index k = 0; k < x.size(); ++k) moved[k] = !linear_[static_cast<std::size_t>(k)];
  for (std::uint32_t left = held; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const Rows rows = rows_into(i);
    for (int k = rows.first; k < rows.first + rows.count; ++k) {
      moved[k] = moved[k] || contacts_.into(k, i) != 0.0;
    }
  }
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    // From at_ on, not from x_probe: an angle or a rotation there may be one turn or one sign away.
    if (moved[k]) x[k] = at_[k] + y[k];
  }
  for (std::uint32_t left = held; left != 0; left &= left - 1) {
    push(x, -l[std::countr_zero(left)], std::countr_zero(left));
  }
}

}  // namespace haptic::core
