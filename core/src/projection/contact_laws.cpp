#include "haptic/core/projection/contact_laws.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace haptic::core {

void ContactLaws::rewind() noexcept {
  for (int i = 0; i < count_; ++i) {
    if (!has(i)) continue;
    v_[i] = told_v_[i];
    s_[i] = l_[i] = free_[i] = give_[i] = root_[i] = jump_[i] = 0.0;
  }
  time_ = 0.0;
  dt_ = -1.0;  // no step's: give() changes with the next one
}

void ContactLaws::take(const PlaneSet::Laws& told, int i, double velocity, double length,
                       double id) noexcept {
  if (told.cols() == 0 || !(told(PlaneSet::kMass, i) > 0.0)) return;
  const double area = length * length;
  with_ |= 1u << i;
  count_ = std::max(count_, i + 1);
  mass_[i] = told(PlaneSet::kMass, i) * area;
  damping_[i] = told(PlaneSet::kDamping, i) * area;
  stiffness_[i] = told(PlaneSet::kStiffness, i) * area;
  load_[i] = told(PlaneSet::kLoad, i) * length;
  id_[i] = id;
  object_[i] = 0.0;
  v_[i] = told_v_[i] = velocity / length;
  s_[i] = l_[i] = free_[i] = give_[i] = root_[i] = 0.0;
  dt_ = 0.0;
}

void ContactLaws::share(const PlaneSet::Objects& told) noexcept {
  Eigen::Matrix<double, kMaxMotions, kMaxPlanes> unit;
  for (int i = 0; i < static_cast<int>(told.cols()); ++i) {
    const auto direction = told.col(i).tail<kMaxMotions>();
    const double length = direction.stableNorm();
    if (!has(i) || told(0, i) == 0.0 || !(length > 0.0) || !std::isfinite(length)) continue;
    unit.col(i) = direction / length;
    object_[i] = told(0, i);
    for (std::uint32_t left = shared_; left != 0; left &= left - 1) {
      const int j = std::countr_zero(left);
      if (told(0, j) != told(0, i)) continue;
      others_[static_cast<std::size_t>(i)] |= 1u << j;
      others_[static_cast<std::size_t>(j)] |= 1u << i;
      cosine_(i, j) = cosine_(j, i) = unit.col(i).dot(unit.col(j));
    }
    shared_ |= 1u << i;
  }
}

double ContactLaws::give(int i, int j) const noexcept {
  if (i == j) return has(i) ? give_[i] : 0.0;
  if (!ContactDual::has(others_[static_cast<std::size_t>(i)], j)) return 0.0;
  return root_[i] * root_[j] * cosine_(i, j);
}

double ContactLaws::pushed(int i, const Vector& l) const noexcept {
  double sum = give_[i] * l[i];
  for (std::uint32_t left = others_[static_cast<std::size_t>(i)]; left != 0; left &= left - 1) {
    const int j = std::countr_zero(left);
    sum += root_[i] * root_[j] * cosine_(i, j) * l[j];
  }
  return sum;
}

/// M (v' - v) / T = (l + l') / 2 + load - D (s' - s) / T - k (s + s') / 2, s' - s = T (v + v') / 2.
bool ContactLaws::begin(double dt) noexcept {
  const bool changed = dt != dt_;
  dt_ = dt;
  time_ += dt;
  for (int i = 0; changed && i < count_; ++i) {
    if (!has(i)) continue;
    const double inertia = 2.0 * mass_[i] / (dt * dt);
    give_[i] = dt > 0.0 ? 0.5 / (inertia + damping_[i] / dt + 0.5 * stiffness_[i]) : 0.0;
    root_[i] = std::sqrt(give_[i]);
  }
  for (int i = 0; i < count_; ++i) {
    if (!has(i)) continue;
    const double push =
        dt > 0.0 ? 2.0 * mass_[i] * v_[i] / dt - stiffness_[i] * s_[i] + load_[i] : 0.0;
    free_[i] = s_[i] + 2.0 * give_[i] * push + pushed(i, l_);
  }
  return changed;
}

void ContactLaws::end(const Vector& l) noexcept {
  for (int i = 0; i < count_; ++i) {
    if (!has(i)) continue;
    const double s = free_[i] + pushed(i, l);
    if (dt_ > 0.0) v_[i] = 2.0 * (s - s_[i]) / dt_ - v_[i];
    s_[i] = s;
    jump_[i] = std::max(jump_[i], dt_ * std::abs(l[i] - l_[i]));
  }
  l_.head(count_) = l.head(count_);
}

double ContactLaws::energy() const noexcept {
  Vector twice = Vector::Zero();
  for (int i = 0; i < count_; ++i) {
    if (!has(i)) continue;
    twice[i] = mass_[i] * v_[i] * v_[i];
    const double held = load_[i] - stiffness_[i] * s_[i];
    if (stiffness_[i] > 0.0) twice[i] += held * held / stiffness_[i];
    const std::uint32_t before = (1u << i) - 1;
    for (std::uint32_t left = others_[static_cast<std::size_t>(i)] & before; left != 0;
         left &= left - 1) {
      const int j = std::countr_zero(left);
      twice[i] = std::max(twice[i], twice[j]);
      twice[j] = 0.0;
    }
  }
  return 0.5 * twice.sum();
}

}  // namespace haptic::core
