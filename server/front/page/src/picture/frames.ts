// Where the bodies of a drawing are: drawing + q + x -> one transform per body, body to world.

import { Matrix4, Quaternion, Vector3 } from "three";
import {
  DrawnMotion_Kind as Kind, DrawnValue, type DrawnBody, type DrawnMotion, type Drawing,
} from "hapticd";

const ONE = new Vector3(1, 1, 1);
const Z = new Vector3(0, 0, 1);

/** Pose of each body; null: it is not drawn, because this page does not know how it moves. */
export type Frames = readonly (Matrix4 | null)[];

function finite(value: number | undefined): number {
  return value !== undefined && Number.isFinite(value) ? value : 0;
}

/** Three numbers of a message; missing or not finite ones are 0. */
export function vector(values: readonly number[], from = 0): Vector3 {
  return new Vector3(finite(values[from]), finite(values[from + 1]), finite(values[from + 2]));
}

/** x, y, z, w of a message, made a unit quaternion; empty or 0: no rotation. */
function quaternion(values: readonly number[], from = 0): Quaternion {
  const { x, y, z } = vector(values, from);
  const made = new Quaternion(x, y, z, finite(values[from + 3]));
  return made.length() > 0 ? made.normalize() : new Quaternion();
}

function turn(axis: Vector3, angle: number): Matrix4 {
  return new Matrix4().makeRotationAxis(axis, angle);
}

/** Axis times angle. */
function turnByVector(by: Vector3): Matrix4 {
  const angle = by.length();
  return angle > 0 ? turn(by.divideScalar(angle), angle) : new Matrix4();
}

/** The angle of drawing.proto's KIND_AIM: the target is at (X, Y) in the frame so far. */
function aimed(motion: DrawnMotion, frame: Matrix4, earlier: Frames): Matrix4 | null {
  const target = earlier[motion.target];
  if (!target) return null;
  const at = vector(motion.targetPoint).applyMatrix4(target).applyMatrix4(frame.clone().invert());
  const away = Math.hypot(at.x, at.y);
  const height = away > 0 ? Math.min(Math.max(motion.offset / away, -1), 1) : 0;
  return turn(Z, Math.atan2(at.y, at.x) - Math.asin(height));
}

/** Null: of a kind that this page does not know. */
function moved(
  motion: DrawnMotion,
  values: readonly number[],
  frame: Matrix4,
  earlier: Frames,
): Matrix4 | null {
  const amount = motion.factor * finite(values[motion.index]) + motion.offset;
  switch (motion.kind) {
    case Kind.ROTATION:
      return turn(vector(motion.axis), amount);
    case Kind.TRANSLATION: {
      const { x, y, z } = vector(motion.axis).multiplyScalar(amount);
      return new Matrix4().makeTranslation(x, y, z);
    }
    case Kind.ORIENTATION:
      return new Matrix4().makeRotationFromQuaternion(quaternion(values, motion.index));
    case Kind.ROTATION_VECTOR:
      return turnByVector(vector(values, motion.index));
    case Kind.AIM:
      return aimed(motion, frame, earlier);
    default:
      return null;
  }
}

function frameOf(
  body: DrawnBody,
  q: readonly number[],
  x: readonly number[],
  earlier: Frames,
): Matrix4 | null {
  const parent = body.parent < 0 ? new Matrix4() : earlier[body.parent];
  if (!parent) return null;
  const frame = parent.clone();
  frame.multiply(new Matrix4().compose(vector(body.position), quaternion(body.orientation), ONE));
  for (const motion of body.motions) {
    const values = motion.value === DrawnValue.Q ? q : motion.value === DrawnValue.X ? x : [];
    const step = moved(motion, values, frame, earlier);
    if (!step) return null;
    frame.multiply(step);
  }
  return frame;
}

/** A parent comes before its children. */
export function frames(drawing: Drawing, q: readonly number[], x: readonly number[]): Frames {
  const all: (Matrix4 | null)[] = [];
  for (const body of drawing.bodies) all.push(frameOf(body, q, x, all));
  return all;
}
