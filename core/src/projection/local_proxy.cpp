#include "haptic/core/projection/local_proxy.hpp"

namespace haptic::core {

void LocalProxy::accept(const ProxySnapshot& sample) noexcept {
  const bool same =
      sample.epoch == sample_.epoch && sample.seq == sample_.seq && sample.mode == sample_.mode;
  sample_ = sample;
  if (!same) pending_ = true;
}

void LocalProxy::forget() noexcept {
  sample_ = ProxySnapshot{};
  pending_ = false;
}

const VecX& LocalProxy::at(const VecX& x_probe) noexcept {
  changed_ = pending_;
  pending_ = false;
  switch (sample_.mode) {
    case ProxyMode::kHeld:
      return sample_.x;
    case ProxyMode::kFree:
      return x_probe;
    case ProxyMode::kNone:
      break;
  }
  x_.resize(0);
  return x_;
}

}  // namespace haptic::core
