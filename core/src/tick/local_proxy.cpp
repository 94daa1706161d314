#include "local_proxy.hpp"

namespace haptic::core {

const VecX& LocalProxy::step(const ProxySnapshot& sample, const VecX& x_probe) noexcept {
  const bool same = sample.tenure == tenure_ && sample.seq == seq_ && sample.mode == mode_;
  mode_ = sample.mode;
  tenure_ = sample.tenure;
  seq_ = sample.seq;
  new_sample_ = changed_ = !same && mode_ != ProxyMode::kNone;
  in_the_way_ = false;
  planes_ = PlaneStatus::kFree;
  active_planes_ = 0;
  switch (mode_) {
    case ProxyMode::kHeld:
      in_the_way_ = true;
      return sample.x;
    case ProxyMode::kFree:
      return x_probe;
    case ProxyMode::kPlanes:
      if (new_sample_) projection_.set(sample.planes, sample.x);
      planes_ = projection_.project(x_probe, x_);
      active_planes_ = projection_.active();
      in_the_way_ = changed_ = planes_ != PlaneStatus::kFree;
      return x_;
    case ProxyMode::kNone:
      break;
  }
  x_.resize(0);
  return x_;
}

}  // namespace haptic::core
