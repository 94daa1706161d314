/** Contacts for a simulation that knows its own geometry: where a point of the tool is, how near an
 * object is to it, and how that object gives way. contactAt() makes of these the Plane that the
 * server evaluates at 1 kHz (proto/README.md#contacts), second order included.
 *
 * Frame: any one that the point, the normal and the curvature share and that does not move with the
 * coordinates: the world, or the hand if the joints' angles are all that X has. */
import { getOption } from "@bufbuild/protobuf";
import { by_coupling, of_geometry } from "./gen/haptic/v1/field_options_pb.js";
import { PlaneSchema } from "./gen/haptic/v1/session_pb.js";
import type { Plane } from "./proxy.js";
import { add, cross, dot } from "./vectors.js";
import type { Vector3 } from "./vectors.js";

/** A point of the tool, and how it moves with n <= 8 consecutive coordinates. */
export interface PointMap {
  firstCoordinate: number;
  /** p, m. */
  position: Vector3;
  /** n: dp/dx_j, m per unit of x_j. */
  jacobian: Vector3[];
  /** d2p/dx_j dx_k, m per product of their units: lower triangle, row by row. Empty: 0. */
  second: Vector3[];
}

/** A joint as it stands now. */
export interface JointAxis {
  /** A point of the axis, m; without a meaning if prismatic. */
  origin: Vector3;
  /** Axis of length 1; right-handed. */
  axis: Vector3;
  prismatic?: boolean;
}

/** Vector of f(k) for the three directions. */
const vector = (f: (k: 0 | 1 | 2) => number): Vector3 => [f(0), f(1), f(2)];
/** f(j, k) for the lower triangle of an n x n matrix, row by row. */
function triangle<T>(n: number, f: (row: number, column: number) => T): T[] {
  const values: T[] = [];
  for (let row = 0; row < n; ++row) {
    for (let column = 0; column <= row; ++column) values.push(f(row, column));
  }
  return values;
}

/** Coordinates: the joints of a serial chain, rad or m, from the base on; `point` is on the last
 * one's link. dp/dx_j = a_j x (p - o_j) and d2p/dx_j dx_k = a_j x dp/dx_k for j <= k; a prismatic
 * joint k has dp/dx_k = a_k, and d2p/dx_j dx_k = 0 for a prismatic j. */
export function pointOnJoints(joints: JointAxis[], point: Vector3, firstCoordinate = 0): PointMap {
  const jacobian = joints.map(({ origin, axis, prismatic }) =>
    prismatic ? axis : cross(axis, add(point, -1, origin)));
  const second = triangle(joints.length, (k, j) =>
    joints[j]!.prismatic ? vector(() => 0) : cross(joints[j]!.axis, jacobian[k]!));
  return { firstCoordinate, position: point, jacobian, second };
}

/** Coordinates: the flexions of a planar finger (MCP, PIP), rad, from `firstCoordinate` of x on.
 * Frame: the finger's hand frame, origin on the first axis, +x distal, +y dorsal, so that at zero
 * all phalanges lie along +x, and flexion turns them to -y. The point is `along` phalanx number
 * `phalanx` (0, 1, ...) from its joint, and `palmar` of its line, m. */
export function pointOnFinger(lengths: number[], x: number[], phalanx: number, along: number,
                              palmar = 0, firstCoordinate = 0): PointMap {
  const joints: JointAxis[] = [];
  let origin: Vector3 = [0, 0, 0], angle = 0;
  for (let k = 0; k <= phalanx; ++k) {
    if (k > 0) {
      const length = lengths[k - 1]!;
      origin = [origin[0] + length * Math.cos(angle), origin[1] - length * Math.sin(angle), 0];
    }
    angle += x[firstCoordinate + k]!;
    joints.push({ origin, axis: [0, 0, -1] });
  }
  const c = Math.cos(angle), s = Math.sin(angle);
  return pointOnJoints(joints, [origin[0] + along * c - palmar * s,
    origin[1] - along * s - palmar * c, 0], firstCoordinate);
}

/** Coordinates: x, y, z of the point itself (an output of kind point), m. */
export function pointItself(x: number[], firstCoordinate = 0): PointMap {
  return { firstCoordinate, position: vector((k) => x[firstCoordinate + k]!),
    jacobian: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], second: [] };
}

/** Coordinates: x, y, z, m, and a quaternion qx, qy, qz, qw (an output of kind frame, a palm, a
 * stylus), which is normalised, and the derivatives are those of that. `offset`: the point in that
 * frame, m. */
export function pointOnPose(x: number[], offset: Vector3, firstCoordinate = 0): PointMap {
  const itself = pointItself(x, firstCoordinate);
  const raw = x.slice(firstCoordinate + 3, firstCoordinate + 7);
  const length = Math.hypot(...raw);
  const q = raw.map((part) => part / length) as [number, number, number, number];
  const v: Vector3 = [q[0], q[1], q[2]], w = q[3], r = offset;
  // R r is a quadratic form of q with the second derivative 2 M = twice.
  const unit: Vector3[] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const twice = (i: number, j: number): Vector3 => {
    if (i === 3 && j === 3) return vector((k) => 2 * r[k]);
    if (i === 3 || j === 3) {
      const turn = cross(unit[Math.min(i, j)]!, r);
      return vector((k) => 2 * turn[k]);
    }
    return vector((k) =>
      2 * ((k === i ? r[j]! : 0) + (k === j ? r[i]! : 0) - (i === j ? r[k] : 0)));
  };
  const vxr = cross(v, r), vr = dot(v, r);
  const turned = vector((k) => (w * w - dot(v, v)) * r[k] + 2 * v[k] * vr + 2 * w * vxr[k]);
  // The derivatives of q^T M q / q^T q.
  const slope = q.map((_, i) => vector((k) => q.reduce((s, qj, j) => s + twice(i, j)[k] * qj, 0)));
  const bend = (i: number, j: number): Vector3 => vector((k) => (twice(i, j)[k] -
    2 * (slope[i]![k] * q[j]! + slope[j]![k] * q[i]!) +
    (8 * q[i]! * q[j]! - (i === j ? 2 : 0)) * turned[k]) / length ** 2);
  return {
    firstCoordinate,
    position: add(itself.position, 1, turned),
    jacobian: [...itself.jacobian,
      ...slope.map((s, i) => vector((k) => (s[k] - 2 * q[i]! * turned[k]) / length))],
    second: triangle(7, (i, j) => (j >= 3 ? bend(i - 3, j - 3) : vector(() => 0))),
  };
}

/** Second derivative of an object's gap by the point, 1/m: xx, yx, yy, zx, zy, zz. */
export type Curvature3 = readonly number[];

const across = (directions: Vector3[], distance: number): Curvature3 => triangle(3, (i, j) =>
  ((i === j ? 1 : 0) - directions.reduce((sum, a) => sum + a[i]! * a[j]!, 0)) / distance);

/** Curvature of a ball; `distance` of the point from its centre, m, != 0; < 0: the point is inside
 * a hollow one, and the normal points inwards. */
export const sphereCurvature = (normal: Vector3, distance: number): Curvature3 =>
  across([normal], distance);
/** Curvature of a cylinder with this axis (of length 1); `distance` from the axis. */
export const cylinderCurvature = (normal: Vector3, axis: Vector3, distance: number): Curvature3 =>
  across([normal, axis], distance);

/** A point of the tool against an object; and id, velocity, mass and what else a Plane tells as
 * well, in the units of session.proto. An object that is pushed needs an id and a mass. An absent
 * objectDirection is the normal, of a body that does not turn. */
export interface Contact extends Omit<Plane,
    "normal" | "offset" | "compliance" | "curvature" | "firstCoordinate"> {
  point: PointMap;
  /** Normal of the object at the nearest point, outwards, of length 1. */
  normal: Vector3;
  /** From the object to the point along the normal, m; < 0: inside. */
  gap: number;
  /** Absent: flat. */
  curvature?: Curvature3;
  /** Stiffness of point and object in series, N/m, > 0. Absent: rigid. */
  stiffness?: number;
}

/** The fields that contact and plane have by the same name. */
function toldOf(contact: Contact, coupling: number): Partial<Plane> {
  const told: Record<string, unknown> = {}, given = contact as unknown as Record<string, unknown>;
  for (const field of PlaneSchema.fields) {
    if (getOption(field, of_geometry)) continue;
    const absent = field.proto.proto3Optional ? undefined : field.fieldKind === "list" ? [] : 0;
    const value = given[field.localName] ?? absent;
    if (value === undefined) continue;
    told[field.localName] = getOption(field, by_coupling) ? (value as number) / coupling : value;
  }
  if (contact.object && !contact.objectDirection) told["objectDirection"] = [...contact.normal];
  return told;
}

/** The contact as the server takes it, linearised at the sample's position `x`. `coupling`: c of
 * the simulation's own coupling, whose energy is c/2 |x - xProbe|^2: N/m if x is in m, N m/rad if
 * in rad. Throws RangeError if the point's coordinates do not lie within x. */
export function contactAt(x: number[], contact: Contact, coupling: number): Plane {
  const { point: { firstCoordinate: first, jacobian, second }, normal: n, gap } = contact;
  const count = jacobian.length, K = contact.curvature ?? Array<number>(6).fill(0);
  if (!(first >= 0 && first + count <= x.length)) {
    throw new RangeError(`firstCoordinate ${first}, ${count} coordinates: must lie within the ` +
      `${x.length} of x`);
  }
  if (second.length !== 0 && second.length !== count * (count + 1) / 2) {
    throw new RangeError(`second: has ${second.length} vectors for ${count} coordinates`);
  }
  const gradient = jacobian.map((column) => dot(n, column));
  const bent = jacobian.map(([a, b, c]): Vector3 => [K[0]! * a + K[1]! * b + K[3]! * c,
    K[1]! * a + K[2]! * b + K[4]! * c, K[3]! * a + K[4]! * b + K[5]! * c]);
  const curvature = triangle(count, (j, k) => dot(jacobian[k]!, bent[j]!));
  second.forEach((bend, i) => (curvature[i]! += dot(n, bend)));
  return {
    normal: x.map((_, i) => -(gradient[i - first] ?? 0)),
    offset: gap - gradient.reduce((sum, slope, i) => sum + slope * x[first + i]!, 0),
    compliance: coupling / (contact.stiffness ?? Infinity),
    curvature: curvature.some((value) => value !== 0) ? curvature : [],
    firstCoordinate: first,
    ...toldOf(contact, coupling),
  };
}

/** Fastest point of a finger, m/s: 99 % of the time fingertips in recorded grasps are slower than
 * 0.29 to 0.54 m/s. */
const FASTEST_POINT = 0.5;
const UNKNOWN_ROUND_TRIP_MS = 200;

/** Contacts with a gap up to this, m, should be told before they are touched: how far a point may
 * get until the next sample's law is in use. `roundTripMs`: Session.roundTripMs; `periodMs`: of
 * your samples; `vMax`: of the point, m/s. */
export function contactHorizon(roundTripMs: number, periodMs: number,
                               vMax = FASTEST_POINT): number {
  return vMax * ((roundTripMs || UNKNOWN_ROUND_TRIP_MS) + periodMs) / 1000;
}
