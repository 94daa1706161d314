/** How the object of a contact moves when the tool pushes it. */
import type { Contact } from "../contact.js";
import { along } from "../vectors.js";

const MOST_MOTIONS = 6;      // of Plane.objectDirection
const NEW_MOTION = 1e-6;     // square of the part of a direction that is a new one

/** The object of a contact that it can give way to. */
export interface PushedObject {
  /** Has the object's law. */
  told: Contact;
  /** The topmost of the bodies that move with it. */
  root: number;
  /** Force of the contact, N. */
  force: number;
  /** Per DoF that counts: how far the surface recedes, and u. */
  recedes: Float64Array;
  motion: Float64Array;
  /** J H^-1 J^T */
  give: number;
}

/** Directions with these cosines between them, by Cholesky's rule: each is a sum of those that came
 * before it, and of a new one if there is room. */
function findDirections(together: PushedObject[]): void {
  const news: PushedObject[] = [];
  for (const object of together) {
    const e: number[] = [];
    let left = 1;
    for (const base of news) {
      const known = base.told.objectDirection!;
      const cosine = object.give * along(object.motion, base.recedes) /
        Math.sqrt(object.give * base.give);
      e.push((cosine - along(e, known)) / known.at(-1)!);
      left -= e.at(-1)! ** 2;
    }
    if (left > NEW_MOTION && news.length < MOST_MOTIONS) {
      e.push(Math.sqrt(left));
      news.push(object);
    }
    const length = Math.hypot(...e);
    object.told.objectDirection = e.map((part) => part / length);
  }
}

/** Takes all contacts of a step. Contacts on the same body share it: the directions e_i are those
 * of the u_i in the metric H, so e_i . e_j = J_i H^-1 J_j^T / sqrt(J_i H^-1 J_i^T J_j H^-1 J_j^T),
 * and no load holds the force of another of them. */
export function share(objects: PushedObject[]): void {
  const ofRoot = new Map<number, PushedObject[]>();
  for (const object of objects) {
    ofRoot.set(object.root, [...ofRoot.get(object.root) ?? [], object]);
  }
  for (const [root, together] of ofRoot) {
    if (together.length < 2) continue;
    findDirections(together);
    for (const { told, motion } of together) {
      told.object = root;
      for (const other of together) {
        if (other.told !== told) told.load! -= along(motion, other.recedes) * other.force;
      }
    }
  }
}
