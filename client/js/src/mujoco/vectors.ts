/** Vectors and matrices of MuJoCo's arrays, and quaternions as MuJoCo has them: w first. */
import { dot } from "../vectors.js";
import type { Vector3 } from "../vectors.js";

export type Quaternion = readonly [number, number, number, number];
type Numbers = ArrayLike<number>;

export const vectorAt = (numbers: Numbers, i = 0): Vector3 =>
  [numbers[i]!, numbers[i + 1]!, numbers[i + 2]!];
/** The transpose of the 3 x 3 matrix that begins at `i`, times v. */
export const intoFrame = (matrix: Numbers, i: number, v: Vector3): Vector3 =>
  [dot([matrix[i]!, matrix[i + 3]!, matrix[i + 6]!], v),
   dot([matrix[i + 1]!, matrix[i + 4]!, matrix[i + 7]!], v),
   dot([matrix[i + 2]!, matrix[i + 5]!, matrix[i + 8]!], v)];

export const quaternionAt = (numbers: Numbers, i: number): Quaternion =>
  [...vectorAt(numbers, i), numbers[i + 3]!];
export function normalised(q: Quaternion): Quaternion {
  const length = Math.hypot(...q);
  return [q[0] / length, q[1] / length, q[2] / length, q[3] / length];
}
export const conjugate = (q: Quaternion): Quaternion => [q[0], -q[1], -q[2], -q[3]];
export const product = ([a, b, c, d]: Quaternion, [w, x, y, z]: Quaternion): Quaternion =>
  [a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y, a * y - b * z + c * w + d * x,
   a * z + b * y - c * x + d * w];
/** The turn that takes `seconds`, as a rate in rad/s. */
export function rateOf(turn: Quaternion, seconds: number): Vector3 {
  const sine = Math.hypot(turn[1], turn[2], turn[3]);
  if (sine === 0) return [0, 0, 0];
  let angle = 2 * Math.atan2(sine, turn[0]);
  if (angle > Math.PI) angle -= 2 * Math.PI;
  const scale = angle / (seconds * sine);
  return [turn[1] * scale, turn[2] * scale, turn[3] * scale];
}

/** Coordinates that the curvature of a contact may have. */
export const MOST_CURVED = 8;
/** Place in a symmetric matrix that is kept as its lower triangle row by row. */
export const triangle = (a: number, b: number): number =>
  Math.max(a, b) * (Math.max(a, b) + 1) / 2 + Math.min(a, b);
