#include "proxy_intake.hpp"

#include <algorithm>
#include <span>

namespace haptic::core {

namespace {

template <typename Numbers>
bool same(const Numbers& a, const Numbers& b) noexcept {
  return a.rows() == b.rows() && a.cols() == b.cols() && a == b;
}

bool same_lists(const PlaneSet& a, const PlaneSet& b) noexcept {
  return std::apply(
      [&b](const auto&... of_a) {
        return std::apply([&](const auto&... of_b) { return (same(of_a, of_b) && ...); },
                          b.lists());
      },
      a.lists());
}

/// Both say the same of every place. Curved planes begin at x.
bool same_planes(const ProxySnapshot& one, const ProxySnapshot& other) noexcept {
  const PlaneSet &a = one.planes, &b = other.planes;
  const auto first_of = [&a](const PlaneSet::Places& places) {
    return std::span(places).first(static_cast<std::size_t>(a.size()));
  };
  return same(a.offsets, b.offsets) && same(a.normals, b.normals) && same_lists(a, b) &&
         same(a.laws, b.laws) && same(a.objects, b.objects) && same(a.curvature, b.curvature) &&
         std::ranges::equal(first_of(a.curved), first_of(b.curved)) &&
         std::ranges::equal(first_of(a.first), first_of(b.first)) &&
         (a.curvature.size() == 0 || same(one.x, other.x));
}

}  // namespace

ProxyInUse ProxyIntake::step(const TickInput& in, const ProxySnapshot& sample,
                             const StalenessLimits& limits, const TrackerRecord& tracker,
                             LifecycleState last) noexcept {
  const CommandSnapshot& command = in.command;
  const bool offered =
      command.lease_held && sample.mode != ProxyMode::kNone && sample.tenure == command.tenure;
  const bool same = offered && sample.tenure == sample_.tenure && sample.seq == sample_.seq &&
                    sample.mode == sample_.mode;
  const bool usable = same || (offered && fits(sample));
  if (usable && !same && (!carries_force(last) || sample.tenure == sample_.tenure)) {
    moved_ = sample.tenure == sample_.tenure && !same_planes(sample, sample_);
    sample_ = sample;
  } else if (!usable && !carries_force(last) && sample_.mode != ProxyMode::kNone) {
    sample_ = ProxySnapshot{};
  }

  ProxyInUse now;
  if (sample_.mode == ProxyMode::kNone) return now;
  now.mode = sample_.mode;
  now.tenure = sample_.tenure;
  now.seq = sample_.seq;
  now.age = in.now - sample_.born;
  now.level = staleness(now.age, sample_.valid_for, limits);
  now.ladder = ladder(now.age, limits);
  now.gapless_since = sample_.gapless_since;
  now.gapless_samples = sample_.gapless_samples;
  now.too_fast = sample_.too_fast;
  if (tracker.on) now.ladder = std::min(now.ladder, tracker.ladder);
  return now;
}

bool ProxyIntake::fits(const ProxySnapshot& sample) const noexcept {
  if (sample.mode == ProxyMode::kFree) return true;
  if (sample.x.size() != n_x_ || !sample.x.allFinite()) return false;
  if (sample.mode != ProxyMode::kPlanes || sample.planes.size() == 0) return true;
  return sample.planes.fits(n_x_);
}

}  // namespace haptic::core
