#include "haptic/core/contacts/contact_laws.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace haptic::core {

void ContactLaws::rewind() noexcept {
  for (int i = 0; i < count_; ++i) {
    if (!has(i)) continue;
    v_[i] = told_v_[i];
    l_[i] = first_l_[i];
    s_[i] = free_[i] = give_[i] = root_[i] = jump_[i] = 0.0;
  }
  time_ = 0.0;
  dt_ = -1.0;  // what the contacts give way by is of another step
}

void ContactLaws::set(const PlaneSet& told, const Vector& length, std::uint32_t left_out) noexcept {
  begin_sample();
  for (int i = 0; i < static_cast<int>(told.laws.cols()); ++i) {
    if (!ContactDual::has(left_out, i)) take(told, i, length[i]);
  }
  share(told.objects);
  if (any()) correct_masses();
}

void ContactLaws::take(const PlaneSet& told, int i, double length) noexcept {
  const auto law = told.laws.col(i);
  if (!(law[PlaneSet::kMass] > 0.0)) return;
  const double area = length * length;
  with_ |= 1u << i;
  count_ = std::max(count_, i + 1);
  mass_[i] = law[PlaneSet::kMass] * area;
  damping_[i] = law[PlaneSet::kDamping] * area;
  stiffness_[i] = law[PlaneSet::kStiffness] * area;
  load_[i] = law[PlaneSet::kLoad] * length;
  id_[i] = told.ids.size() > 0 ? told.ids[i] : 0.0;
  object_[i] = 0.0;
  v_[i] = told_v_[i] = told.velocity.size() > 0 ? told.velocity[i] / length : 0.0;
  s_[i] = l_[i] = first_l_[i] = free_[i] = give_[i] = root_[i] = 0.0;
  dt_ = 0.0;
}

void ContactLaws::share(const PlaneSet::Objects& told) noexcept {
  Eigen::Matrix<double, kMaxMotions, kMaxPlanes> unit;
  std::fill_n(cosine_.data(), told.cols() * cosine_.cols(), 0.0);
  for (int i = 0; i < static_cast<int>(told.cols()); ++i) {
    const auto direction = told.col(i).tail<kMaxMotions>();
    const double length = direction.stableNorm();
    if (!has(i) || told(0, i) == 0.0 || !(length > 0.0) || !std::isfinite(length)) continue;
    unit.col(i) = direction / length;
    object_[i] = told(0, i);
    std::uint32_t same = 0;
    for (std::uint32_t left = shared_; left != 0 && same == 0;) {
      const int j = std::countr_zero(left);
      const std::uint32_t of_one = others_[static_cast<std::size_t>(j)] | 1u << j;
      if (object_[j] == object_[i]) same = of_one;
      left &= ~of_one;
    }
    others_[static_cast<std::size_t>(i)] = same;
    for (; same != 0; same &= same - 1) {
      const int j = std::countr_zero(same);
      others_[static_cast<std::size_t>(j)] |= 1u << i;
      cosine_(i, j) = cosine_(j, i) = unit.col(i).dot(unit.col(j));
    }
    shared_ |= 1u << i;
  }
}

ContactDual::Gives ContactLaws::gives(const Vector& scale) const noexcept {
  return {dt_ > 0.0 ? shared_ : 0, root_.cwiseProduct(scale), &cosine_};
}

/// Adds whole rows: each of many contacts on one object pushes all.
void ContactLaws::push(const Vector& l) noexcept {
  pushed_.head(count_).setZero();
  for (std::uint32_t left = shared_; left != 0; left &= left - 1) {
    const int j = std::countr_zero(left);
    if (l[j] == 0.0) continue;
    pushed_.head(count_) += root_[j] * l[j] * cosine_.row(j).head(count_).transpose();
  }
  for (int i = 0; i < count_; ++i) {
    if (has(i)) pushed_[i] = give_[i] * l[i] + root_[i] * pushed_[i];
  }
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
  push(l_);
  for (int i = 0; i < count_; ++i) {
    if (!has(i)) continue;
    const double push =
        dt > 0.0 ? 2.0 * mass_[i] * v_[i] / dt - stiffness_[i] * s_[i] + load_[i] : 0.0;
    free_[i] = s_[i] + 2.0 * give_[i] * push + pushed_[i];
  }
  return changed;
}

void ContactLaws::end(const Vector& l) noexcept {
  push(l);
  for (int i = 0; i < count_; ++i) {
    if (!has(i)) continue;
    const double s = free_[i] + pushed_[i];
    if (dt_ > 0.0) v_[i] = 2.0 * (s - s_[i]) / dt_ - v_[i];
    s_[i] = s;
    jump_[i] = std::max(jump_[i], dt_ * std::abs(l[i] - l_[i]));
  }
  l_.head(count_) = l.head(count_);
  if (time_ == 0.0) first_l_.head(count_) = l.head(count_);
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
