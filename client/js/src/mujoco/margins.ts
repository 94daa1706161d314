/** How far away MuJoCo finds contacts of the tool. */
import type { BoundTool } from "./bound_tool.js";
import type { Engine } from "./engine.js";

interface Grown {
  field: "geom_gap" | "pair_gap" | "body_margin";
  index: number;
  /** m, as the model had it. */
  own: number;
}

/** Gaps of the tool's geoms and pairs in the model, and as they were there: contacts are found
 * within margin + gap, and have force within margin. */
export class Margins {
  private readonly all: Grown[] = [];

  constructor(private readonly engine: Engine, tool: BoundTool) {
    const { model, fixed } = engine, bodies = new Set<number>();
    const add = (field: Grown["field"], index: number): void => {
      this.all.push({ field, index, own: model[field][index] });
    };
    // A pair has the larger margin and the larger gap of its two geoms. So those that have some of
    // their own grow too, and what is subtracted stays as it was.
    for (let geom = 0; geom < model.ngeom; ++geom) {
      const own = model.geom_margin[geom] !== 0 || model.geom_gap[geom] !== 0;
      if (!own && !tool.moves(fixed.geomBody[geom]!)) continue;
      add("geom_gap", geom);
      bodies.add(fixed.geomBody[geom]!);
    }
    for (let pair = 0; pair < model.npair; ++pair) {
      const geoms = [model.pair_geom1[pair], model.pair_geom2[pair]];
      if (!geoms.some((geom) => tool.moves(fixed.geomBody[geom]!))) continue;
      add("pair_gap", pair);
    }
    // Bodies of several geoms are first compared as wholes.
    for (const body of bodies) add("body_margin", body);
  }

  /** MuJoCo finds contacts up to `horizon` m farther away, and begins their force where it did. */
  grow(horizon: number): void {
    const { model } = this.engine;
    for (const { field, index, own } of this.all) model[field][index] = own + horizon;
  }
}
