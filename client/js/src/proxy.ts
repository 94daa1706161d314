/** The proxy that a simulation publishes: where its objects let the haptic probe be. */
import type { MessageInitShape } from "@bufbuild/protobuf";
import type { VirtualCoordinate } from "./gen/haptic/v1/haptic_service_pb.js";
import { PlaneSchema, ProxyMode } from "./gen/haptic/v1/session_pb.js";

/** A half space that the proxy must stay in, normal . x <= offset, or a contact, which also says
 * how the object gives way, curves and moves (proto/README.md#contacts). Fields as in
 * session.proto; only `normal` and `offset` are needed. */
export type Plane = Omit<MessageInitShape<typeof PlaneSchema>, "$typeName" | "$unknown"> & {
  normal: number[];
  offset: number;
};

export interface Proxy {
  mode: ProxyMode;
  /** x, per coordinate; may be empty if free. */
  position: number[];
  planes?: Plane[];
  /** `seq` of the state that it was computed from; absent: the last that the session gave you. */
  deviceSeqUsed?: bigint;
  /** May count as fresh for so long, us; absent: as the scene says. */
  validForUs?: number;
}

export const Proxy = {
  /** The proxy stays at `x` until the next sample. A coordinate in which `x` is the xProbe of
   * `deviceSeqUsed` follows the probe instead, as if free, unless the sample before held it at the
   * same value. Force begins with a held proxy only after a free one, because it does not say on
   * which side of an object the probe is. */
  held: (x: number[]): Proxy => ({ mode: ProxyMode.HELD, position: x }),
  /** The server keeps the probe out of `planes` at 1 kHz; `x` is where they are linearised. Force
   * may begin inside an object. The deepest MAX_PLANES are sent. */
  behind: (planes: Plane[], x: number[]): Proxy =>
    ({ mode: ProxyMode.PLANES, position: x, planes }),
  /** Nothing is in the way: no force, and no drag. */
  free: (): Proxy => ({ mode: ProxyMode.FREE, position: [] }),
};

/** A pose of the tracked body: position x, y, z in m, orientation a unit quaternion x, y, z, w. */
export interface Pose {
  position: number[];
  orientation: number[];
  validForUs?: number;
}

// Limits of one sample (proto/README.md).
export const MAX_PLANES = 32;
export const MAX_CONTACTS_OF_BLOCK = 8;
export const MAX_CURVATURES = 320;
export const MAX_NUMBERS_OF_PLANE = 80;

type Kinds = readonly Pick<VirtualCoordinate, "kind">[];

/** xProbe (-) x as the server takes it: an angle the short way round, a quaternion with the sign
 * that is nearer to x. */
export function difference(coordinates: Kinds, xProbe: number[], x: number[]): number[] {
  const away = x.map((value, i) => xProbe[i]! - value);
  for (let i = 0; i < away.length; ++i) {
    const kind = coordinates[i]!.kind;
    if (kind === "angle") away[i]! -= 2 * Math.PI * Math.round(away[i]! / (2 * Math.PI));
    if (kind !== "quaternion") continue;
    let same = 0;
    for (let k = i; k < i + 4; ++k) same += xProbe[k]! * x[k]!;
    for (let k = i; k < i + 4 && same < 0; ++k) away[k] = -xProbe[k]! - x[k]!;
    i += 3;
  }
  return away;
}

const isContact = (plane: Plane): boolean =>
  (plane.compliance ?? 0) > 0 || (plane.curvature?.length ?? 0) > 0 || (plane.id ?? 0) !== 0;

const shareCoordinate = (a: Plane, b: Plane): boolean =>
  a.normal.some((value, i) => value !== 0 && b.normal[i] !== 0);

/** The planes that xProbe is deepest beyond, or nearest to, in their order. From the deepest
 * on it takes up to MAX_PLANES; a contact (a plane with compliance, curvature or id) only if fewer
 * than MAX_CONTACTS_OF_BLOCK of those taken share a coordinate with it. A curvature that has no
 * room left becomes 0. `x`: where they are linearised, and the probe if that is not known (empty).
 */
export function keepDeepest(coordinates: Kinds, x: number[], xProbe: number[],
                            planes: Plane[]): Plane[] {
  const n = coordinates.length;
  if (x.length !== n || planes.some((plane) => plane.normal.length !== n)) {
    return planes.slice(0, MAX_PLANES);
  }
  const away = xProbe.length === n ? difference(coordinates, xProbe, x) : x.map(() => 0);
  const depth = planes.map((plane) => {
    const beyond = plane.normal.reduce((sum, v, i) => sum + v * (x[i]! + away[i]!), -plane.offset);
    const deep = beyond / Math.hypot(...plane.normal);
    return Number.isFinite(deep) ? deep : -Infinity;
  });
  const chosen = new Map<number, Plane>();
  let curvatures = 0;
  for (const i of [...planes.keys()].sort((a, b) => depth[b]! - depth[a]! || a - b)) {
    let plane = planes[i]!;
    const near = [...chosen.values()].filter((o) => isContact(o) && shareCoordinate(o, plane));
    if (chosen.size === MAX_PLANES) break;
    if (isContact(plane) && near.length >= MAX_CONTACTS_OF_BLOCK) continue;
    const count = plane.curvature?.length ?? 0;
    if (curvatures + count > MAX_CURVATURES || n + count > MAX_NUMBERS_OF_PLANE) {
      const { uncertainty: _, ...flat } = plane;  // it is told as flat, which it is not
      plane = { ...flat, curvature: [] };
    } else {
      curvatures += count;
    }
    chosen.set(i, plane);
  }
  return [...chosen.keys()].sort((a, b) => a - b).map((i) => chosen.get(i)!);
}
