#include "local_proxy.hpp"

namespace haptic::core {

void LocalProxy::step(const ProxySnapshot& sample, const Moment& moment, const VecX& x_probe,
                      Anchor& now) noexcept {
  past_.push(moment.tick, x_probe);
  const bool same = sample.tenure == tenure_ && sample.seq == seq_ && sample.mode == mode_;
  mode_ = sample.mode;
  tenure_ = sample.tenure;
  seq_ = sample.seq;
  new_sample_ = changed_ = !same && mode_ != ProxyMode::kNone;
  switch (mode_) {
    case ProxyMode::kHeld:
      now.in_the_way = true;
      now.x = sample.x;
      break;
    case ProxyMode::kFree:
      now.x = x_probe;
      break;
    case ProxyMode::kPlanes:
      if (new_sample_) {
        const bool anchored = past_.find(sample.anchored_at, used_);
        projection_.set(sample.planes, sample.x, anchored ? &used_ : nullptr);
      }
      now.planes = projection_.project(x_probe, now.x, moment.age);
      now.stored = projection_.stored();
      now.unexplained = projection_.unexplained();
      now.active_planes = projection_.active();
      now.in_the_way = changed_ = now.planes != PlaneStatus::kFree;
      break;
    case ProxyMode::kNone:
      break;
  }
}

}  // namespace haptic::core
