#include "haptic/core/tick/probe_completion.hpp"

#include <algorithm>

namespace haptic::core {

ProbeCompletion::ProbeCompletion(const Kinematics& kinematics) {
  for (const MapBlock& block : kinematics.blocks()) {
    Part part;
    part.at = block;
    part.n_q = block.kinematics->layout().n_q();
    part.n_x = block.kinematics->space().n_x();
    part.x = VecX::Zero(part.n_x);
    parts_.push_back(part);
  }
}

void ProbeCompletion::complete(TickRecord& record) noexcept {
  const bool follows = record.x.size() > 0 && record.proxy_mode != ProxyMode::kHeld;
  BlockSet open = record.unprobed;
  for (Part& part : parts_) {
    const bool unprobed = (open & 1u) != 0;
    open >>= 1;
    double* const x_probe = record.x_probe.data() + part.at.first_x;
    if (!unprobed) {
      std::copy(x_probe, x_probe + part.n_x, part.x.data());
      continue;
    }
    const VecQ q = record.q.segment(part.at.first_q, part.n_q);
    static_cast<void>(part.at.kinematics->position(q, part.x));  // without a value it is untouched
    std::copy_n(part.x.data(), part.n_x, x_probe);
    if (follows) std::copy_n(part.x.data(), part.n_x, record.x.data() + part.at.first_x);
  }
}

}  // namespace haptic::core
