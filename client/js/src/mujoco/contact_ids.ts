/** Names of contacts that last from sample to sample. */
import type { Vector3 } from "../vectors.js";
import { add, dot } from "../vectors.js";

interface Place {
  id: number;
  onTool: Vector3;
  /** Told in the sample before; in this one. */
  before: boolean;
  now: boolean;
}

/** The life of an id. It belongs to a pair of geoms and to one of the places where these meet: two
 * boxes meet in up to eight. A pair's contacts get the ids of those of the sample before that were
 * nearest on the tool, then ids of the pair that were out of use, then new ones. So a pair that
 * meets in one place has one id for ever, and an id that is not told comes back only for its pair.
 */
export class ContactIds {
  private readonly pairs = new Map<string, Place[]>();
  private last = 0;

  /** Begins a sample. */
  begin(): void {
    for (const places of this.pairs.values()) {
      for (const place of places) {
        place.before = place.now;
        place.now = false;
      }
    }
  }

  /** `onTool`: the contact in the frame of the tool's geom, m. */
  id(pair: string, onTool: Vector3): number {
    let places = this.pairs.get(pair);
    if (!places) this.pairs.set(pair, places = []);
    let best: Place | undefined, nearest = 0;
    for (const place of places) {
      if (place.now) continue;
      const apart = add(place.onTool, -1, onTool), distance = dot(apart, apart);
      const better = !best || (place.before && !best.before) ||
        (place.before === best.before && distance < nearest);
      if (!better) continue;
      best = place;
      nearest = distance;
    }
    if (!best) places.push(best = { id: ++this.last, onTool, before: false, now: false });
    best.onTool = onTool;
    best.now = true;
    return best.id;
  }
}
