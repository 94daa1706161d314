#pragma once
/// What each of the paper's renderers would have commanded in a tick that happened: for pictures in
/// which the methods are compared on the same data.
///
/// All four get the q, the proxy x and the stiffness Z_q of the record and answer
///   tau = clamp(g Z_q S (q* - q), +-g tau_max), where Z_q is coupled the subspace methods as a whole,
/// with the gain g and the force limit tau_max of that tick, so that the curves share one scale.
/// Left out for all: damping, direction guard, slew limit. The renderer in use is computed anew
/// like the others. In free mode and without a proxy the force is 0.

#include <array>
#include <memory>
#include <vector>

#include "haptic/core/passivity/spring_storage.hpp"
#include "haptic/core/projection/block_map.hpp"
#include "haptic/core/projection/block_renderer.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "haptic/core/tick/tick_record.hpp"

namespace haptic::server {

class RendererComparison {
 public:
  /// `kinematics` may be shared. `scene`: the widest settings of the device.
  RendererComparison(std::shared_ptr<const core::Kinematics> kinematics, core::RenderSettings scene,
                     const core::ProjectionSettings& projection = {});

  /// tau_a (n_a, N or N m) by kind, in the order of core::kRenderers; NaN where f has no value at q in a block
  /// that the tick asked for it. In those that nothing could hold (TickRecord::unprobed) it is 0, as
  /// the tick's is, whether f has a value or not. Records completed, and in the order of their ticks:
  /// the exact renderer starts from its last answer.
  [[nodiscard]] const std::array<core::VecA, core::kRenderers.size()>& evaluate(
      const core::TickRecord& record);

 private:
  const std::shared_ptr<const core::Kinematics> kinematics_;
  const core::RenderSettings scene_;
  const core::ProjectionModel model_;
  core::BlockMap map_;
  std::vector<core::BlockRenderer> renderers_;  ///< block by block, as in the tick
  std::array<core::VecA, core::kRenderers.size()> tau_{};
  core::VecX last_x_{};
  core::VecX dx_{};
  core::Projection projection_{};
  core::SpringStorage spring_{};  ///< of the subspace methods where Z_q is coupled
};

}  // namespace haptic::server
