#pragma once
/// Completes the records that a tick leaves open: the haptic probe and the proxy of the blocks that
/// nothing could hold (TickRecord::unprobed). A free finger's f is wanted by whoever watches it, not
/// by the force; so it is computed where a record leaves the real-time loop, off its thread, and
/// before anybody reads the record.

#include <vector>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/tick/tick_record.hpp"

namespace haptic::core {

class ProbeCompletion {
 public:
  /// `kinematics`, the pipeline's, must outlive this.
  explicit ProbeCompletion(const Kinematics& kinematics);

  /// Every record of a pipeline in their order. Writes f(q) of the unprobed blocks into x_probe, and
  /// into x where the proxy follows the probe, the same to the bit as a tick that asks for them.
  /// Where f has no value at q the block's last one stays, as in a tick; 0 before the first.
  /// `unprobed` still says which they were. Never allocates, throws.
  void complete(TickRecord& record) noexcept;

 private:
  struct Part {
    MapBlock at{};
    int n_q{0}, n_x{0};
    VecX x{};  ///< newest f(q) that it had
  };
  std::vector<Part> parts_{};  ///< none where the map has no blocks: nothing is left open
};

}  // namespace haptic::core
