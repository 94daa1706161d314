#pragma once
/// The force that each of the paper's renderers would have commanded in a recorded tick, so that
/// pictures compare the methods on the same data.
///
/// All of them get the q, the proxy x and the stiffness Z_q of the record and answer
///   tau = clamp(g Z_q S (q* - q), +-g tau_max)
/// with the gain g and the force limit tau_max of that tick, so that the curves share one scale. If
/// Z_q is coupled, the subspace methods are clamped as a whole. Damping, direction guard and slew
/// limit are left out for all, the renderer in use too. In free mode and without a proxy the force
/// is 0.

#include <array>
#include <memory>
#include <vector>

#include "haptic/core/rendering/block_map.hpp"
#include "haptic/core/rendering/block_renderer.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "haptic/core/tick/tick_record.hpp"

namespace haptic::server {

class RendererComparison {
 public:
  /// `kinematics` may be shared.
  explicit RendererComparison(std::shared_ptr<const core::Kinematics> kinematics,
                              const core::ProjectionSettings& projection = {});

  /// tau_a (n_a, N or N m) by kind, in the order of core::kPaperRenderers; NaN if f has no value at
  /// q in a block that the proxy can hold. In the others (Anchor::free) it is 0, as in the tick.
  /// Records in the order of their ticks: the exact renderer starts from its last answer.
  [[nodiscard]] const std::array<core::VecA, core::kPaperRenderers.size()>& evaluate(
      const core::TickRecord& record);

 private:
  const std::shared_ptr<const core::Kinematics> kinematics_;
  const core::ProjectionModel model_;
  core::BlockMap map_;
  std::vector<core::BlockRenderer> renderers_;  ///< block by block, as in the tick
  std::array<core::VecA, core::kPaperRenderers.size()> tau_{};
  core::VecX last_x_{};
  core::VecX dx_{};
  core::Projection projection_{};
};

}  // namespace haptic::server
