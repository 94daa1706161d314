#include "haptic/core/projection/local_proxy.hpp"

namespace haptic::core {

void LocalProxy::accept(const ProxySnapshot& sample) noexcept {
  const bool same =
      sample.epoch == sample_.epoch && sample.seq == sample_.seq && sample.mode == sample_.mode;
  sample_ = sample;
  if (same) return;
  pending_ = true;
  if (sample.mode == ProxyMode::kPlanes) projection_.set(sample.planes, sample.x);
}

void LocalProxy::forget() noexcept {
  sample_ = ProxySnapshot{};
  pending_ = false;
}

const VecX& LocalProxy::at(const VecX& x_probe) noexcept {
  changed_ = pending_;
  pending_ = false;
  constrained_ = false;
  planes_ = PlaneStatus::kFree;
  active_planes_ = 0;
  switch (sample_.mode) {
    case ProxyMode::kHeld:
      constrained_ = true;
      return sample_.x;
    case ProxyMode::kFree:
      return x_probe;
    case ProxyMode::kPlanes:
      planes_ = projection_.project(x_probe, x_);
      active_planes_ = projection_.active();
      constrained_ = changed_ = planes_ != PlaneStatus::kFree;
      return x_;
    case ProxyMode::kNone:
      break;
  }
  x_.resize(0);
  return x_;
}

}  // namespace haptic::core
