// Corrects told masses by the velocities that samples tell (core/METHOD.md#pushed-objects).
#include <algorithm>
#include <bit>
#include <cmath>

#include "haptic/core/contacts/contact_laws.hpp"

namespace haptic::core {

namespace {

/// Share of the forces on an object by which a comparison of velocities may be wrong.
constexpr double kWrong = 1e-2;
/// It may also be wrong by this multiple of the largest change of l within a step.
constexpr double kJump = 3.0;

}  // namespace

void ContactLaws::begin_sample() noexcept {
  compared_s_ = compared_ ? time_ : 0.0;
  compared_ = false;
  int known = 0;
  for (int i = 0; i < count_; ++i) {
    if (!has(i) || id_[i] == 0.0) continue;
    Before& before = before_[static_cast<std::size_t>(known++)];
    before.id = id_[i];
    before.object = object_[i];
    before.ratio = ratio_[static_cast<std::size_t>(i)];
    before.v = told_v_[i];
    const double ratio = before.ratio.value(), told = mass_[i] * ratio;
    before.load = load_[i] - stiffness_[i] * s_[i];
    before.faster = (v_[i] - told_v_[i]) / ratio;
    const double acts = l_[i] + std::abs(before.load) + damping_[i] * std::abs(v_[i]);
    before.wrong = (kJump * jump_[i] + kWrong * time_ * acts) / told;
  }
  known_ = known;
  with_ = shared_ = 0;
  count_ = 0;
  time_ = 0.0;
  give_.setZero();
  root_.setZero();
  others_.fill(0);
}

/// A load that is told to have changed is taken to have done so evenly.
MassRatio::Seen ContactLaws::recall(int i) noexcept {
  MassRatio& ratio = ratio_[static_cast<std::size_t>(i)];
  ratio = MassRatio{};
  MassRatio::Seen seen;
  for (int j = 0; j < known_; ++j) {
    const Before& before = before_[static_cast<std::size_t>(j)];
    const bool same = before.id == id_[i];
    if (!same && (object_[i] == 0.0 || before.object != object_[i])) continue;
    ratio = before.ratio;
    if (!same) continue;
    const double by_load = 0.5 * compared_s_ * (load_[i] - before.load) / mass_[i];
    if (compared_s_ > 0.0) {
      seen.add(mass_[i], before.faster + by_load, v_[i] - before.v, before.wrong);
    }
    break;
  }
  return seen;
}

void ContactLaws::correct_masses() noexcept {
  std::array<MassRatio::Seen, kMaxPlanes> seen;
  for (int i = 0; i < count_; ++i) {
    if (has(i)) seen[static_cast<std::size_t>(i)] = recall(i);
  }
  for (int i = 0; i < count_; ++i) {
    if (!has(i)) continue;
    const auto at = static_cast<std::size_t>(i);
    MassRatio::Seen all = seen[at];
    for (std::uint32_t left = others_[at]; left != 0; left &= left - 1) {
      all += seen[static_cast<std::size_t>(std::countr_zero(left))];
    }
    ratio_[at].learn(all, compared_s_);
  }
  for (int i = 0; i < count_; ++i) {
    if (has(i)) mass_[i] /= ratio_[static_cast<std::size_t>(i)].value();
  }
}

}  // namespace haptic::core
