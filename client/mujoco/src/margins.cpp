#include "margins.hpp"

namespace haptic::mujoco {

Margins::Margins(mjModel& model, const BoundTool& tool) {
  // A pair has the larger margin and the larger gap of its two geoms. So those that have some of
  // their own grow too, and what is subtracted stays as it was.
  for (int geom = 0; geom < model.ngeom; ++geom) {
    mjtNum &margin = model.geom_margin[geom], &gap = model.geom_gap[geom];
    if (tool.moves(model.geom_bodyid[geom]) || margin != 0.0 || gap != 0.0) {
      margins_.push_back({&margin, &gap, margin, gap});
    }
  }
  for (int pair = 0; pair < model.npair; ++pair) {
    if (!tool.moves(model.geom_bodyid[model.pair_geom1[pair]]) &&
        !tool.moves(model.geom_bodyid[model.pair_geom2[pair]])) {
      continue;
    }
    mjtNum &margin = model.pair_margin[pair], &gap = model.pair_gap[pair];
    margins_.push_back({&margin, &gap, margin, gap});
  }
}

void Margins::grow(double horizon) {
  // From 3.9 on contacts are found within margin + gap and have force within margin; before, within
  // margin, and margin - gap.
  constexpr bool kGapIsAdded = mjVERSION_HEADER >= 3009000;
  for (const Margin& own : margins_) {
    *own.margin = own.own_margin + (kGapIsAdded ? 0.0 : horizon);
    *own.gap = own.own_gap + horizon;
  }
}

}  // namespace haptic::mujoco
