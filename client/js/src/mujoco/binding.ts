/** Which part of a MuJoCo model the device moves: what of it is which coordinate of the device
 * (Device.coordinates, the x of proto/README.md). */
import type { VirtualCoordinate } from "../gen/haptic/v1/haptic_service_pb.js";
import type { Engine } from "./engine.js";

/** One joint, point or pose of the model that follows coordinates of the device. */
export interface Binding {
  /** joint: one coordinate, a hinge's angle, rad, or a slide's way, m. point: three, x, y, z of a
   * site, or of a body's frame, in the world, m. pose: seven, x, y, z, m, and the quaternion qx,
   * qy, qz, qw of a body or site. */
  kind: "joint" | "point" | "pose";
  /** In the model. */
  name: string;
  /** First coordinate of the device. */
  firstCoordinate: number;
  /** For a joint: qpos = offset + scale x. scale != 0; -1: the two count in opposite directions. */
  scale: number;
  offset: number;
}

export const joint = (name: string, coordinate: number, scale = 1, offset = 0): Binding =>
  ({ kind: "joint", name, firstCoordinate: coordinate, scale, offset });
export const point = (siteOrBody: string, firstCoordinate: number): Binding =>
  ({ kind: "point", name: siteOrBody, firstCoordinate, scale: 1, offset: 0 });
export const pose = (siteOrBody: string, firstCoordinate: number): Binding =>
  ({ kind: "pose", name: siteOrBody, firstCoordinate, scale: 1, offset: 0 });

/** The coordinates that a binding takes. */
export const countOf = (kind: Binding["kind"]): number =>
  kind === "joint" ? 1 : kind === "point" ? 3 : 7;

type Names = readonly Pick<VirtualCoordinate, "name">[];

/** True if the coordinates from `first` on are `name` followed by each of `ends`. */
const spells = (coordinates: Names, first: number, name: string, ends: string[]): boolean =>
  ends.every((end, i) => coordinates[first + i]?.name === name + end);

/** Bindings of a model whose names are those of the device's coordinates (Device.coordinates):
 * NAME.x .y .z is a point, with .qx .qy .qz .qw a pose, of the site or body NAME; any other
 * coordinate is the joint of its name. Throws RangeError, with the name that the model has not. */
export function byName(engine: Pick<Engine, "idOf">, coordinates: Names): Binding[] {
  const bindings: Binding[] = [];
  for (let i = 0; i < coordinates.length;) {
    const full = coordinates[i]!.name, dot = full.lastIndexOf(".");
    const name = dot < 0 ? full : full.slice(0, dot);
    if (engine.idOf("JOINT", full) >= 0) {
      bindings.push(joint(full, i++));
      continue;
    }
    if (engine.idOf("SITE", name) < 0 && engine.idOf("BODY", name) < 0) {
      throw new RangeError(`the device has a coordinate '${full}', but the model has no joint of ` +
        `this name and no site or body '${name}'`);
    }
    if (!spells(coordinates, i, name, [".x", ".y", ".z"])) {
      throw new RangeError(
        `coordinate '${full}': a site or body follows x, y and z, or a whole pose`);
    }
    const turns = spells(coordinates, i + 3, name, [".qx", ".qy", ".qz", ".qw"]);
    bindings.push(turns ? pose(name, i) : point(name, i));
    i += turns ? 7 : 3;
  }
  return bindings;
}
