/** MuJoCo's contacts of a tool, touched or near, as contacts of the client library. */
import { cylinderCurvature, sphereCurvature } from "../contact.js";
import type { Contact, Curvature3, PointMap } from "../contact.js";
import type { BoundTool } from "./bound_tool.js";
import { ContactIds } from "./contact_ids.js";
import { ContactSpring } from "./contact_spring.js";
import type { Engine, EngineContact } from "./engine.js";
import { share } from "./pushed_object.js";
import type { PushedObject } from "./pushed_object.js";
import { Surroundings } from "./surroundings.js";
import { add, dot } from "../vectors.js";
import type { Vector3 } from "../vectors.js";
import { intoFrame, MOST_CURVED, triangle, vectorAt } from "./vectors.js";

/** A value of mjContact.exclude; beyond it is not a contact. */
const IN_GAP = 1;

export interface NearContact {
  contact: Contact;
  /** Normal, by MuJoCo, N. */
  force: number;
}

const gapOf = (contact: EngineContact): number => contact.dist - contact.includemargin;
const pairOf = ({ geom1: a, geom2: b }: EngineContact): string =>
  `${Math.min(a, b)} ${Math.max(a, b)}`;

/** a less b, of points that different coordinates may move: how the way between them changes. */
function difference(a: PointMap, b: PointMap): PointMap {
  const end = (map: PointMap) => map.firstCoordinate + map.jacobian.length;
  const low = Math.min(a.firstCoordinate, b.firstCoordinate);
  const count = Math.max(end(a), end(b)) - low;
  const zeros = (length: number) => Array.from({ length }, (): Vector3 => [0, 0, 0]);
  const curved = count <= MOST_CURVED && a.second.length > 0 && b.second.length > 0;
  const out: PointMap = { firstCoordinate: low, position: a.position, jacobian: zeros(count),
                          second: zeros(curved ? triangle(count, 0) : 0) };
  for (const [map, sign] of [[a, 1], [b, -1]] as const) {
    const shift = map.firstCoordinate - low;
    map.jacobian.forEach((way, j) => {
      out.jacobian[shift + j] = add(out.jacobian[shift + j]!, sign, way);
      for (let k = 0; k <= j && curved; ++k) {
        const i = triangle(shift + j, shift + k);
        out.second[i] = add(out.second[i]!, sign, map.second[triangle(j, k)]!);
      }
    });
  }
  return out;
}

/** Round bodies whose middles are closer have no curvature at this point, m: told as flat. */
const LEAST_APART = 1e-6;

export class NearContacts {
  private readonly surroundings: Surroundings;
  private readonly ids = new ContactIds();
  private inside = new Set<string>();

  constructor(private readonly engine: Engine, private readonly tool: BoundTool) {
    this.surroundings = new Surroundings(engine, tool);
  }

  /** Notes the pairs that begin inside each other: they do not count until they were seen apart,
   * because which side the tool came from is not known. */
  begin(): void {
    const all = this.engine.contacts();
    this.inside = new Set(all.filter((c) => this.isOfTool(c) && gapOf(c) < 0).map(pairOf));
  }

  /** Contacts that the last step found. `x`: all coordinates where the tool was then; `rate`: qvel
   * then. */
  find(x: number[], rate: Float64Array): NearContact[] {
    const { engine: { fixed }, tool } = this;
    const all = this.engine.contacts();
    if (this.inside.size > 0) {
      const still = new Set(all.filter((c) => gapOf(c) < 0).map(pairOf));
      for (const pair of this.inside) if (!still.has(pair)) this.inside.delete(pair);
    }
    const near = [...all.entries()].filter(
      ([, c]) => this.isOfTool(c) && !this.inside.has(pairOf(c)));
    const bodies = new Set(near.flatMap(([, c]) => [c.geom1, c.geom2])
      .map((geom) => fixed.geomBody[geom]!).filter((body) => !tool.moves(body)));
    this.ids.begin();
    this.surroundings.look(all, rate, bodies);
    const pushed: PushedObject[] = [];
    const found = near.map(([i, c]) => this.look(i, c, x, pushed));
    share(pushed);
    return found;
  }

  private isOfTool({ geom1, geom2, exclude }: EngineContact): boolean {
    if (geom1 < 0 || geom2 < 0 || exclude > IN_GAP) return false;
    const { geomBody } = this.engine.fixed;
    return this.tool.moves(geomBody[geom1]!) || this.tool.moves(geomBody[geom2]!);
  }

  /** Appends the object to `pushed` if the tool can push it. */
  private look(index: number, c: EngineContact, x: number[], pushed: PushedObject[]): NearContact {
    const { engine, engine: { fixed }, tool } = this;
    const second = tool.moves(fixed.geomBody[c.geom2]!);
    const [geom, other] = second ? [c.geom2, c.geom1] : [c.geom1, c.geom2];
    const body = fixed.geomBody[geom]!, object = fixed.geomBody[other]!;
    const normal = add([0, 0, 0], second ? 1 : -1, c.normal);
    const radius = this.radiusOf(geom);
    const surface = add(c.pos, 0.5 * c.dist, normal), beyond = add(c.pos, -0.5 * c.dist, normal);
    const told: Contact = { normal, gap: gapOf(c),
                            point: tool.pointOn(body, add(surface, radius, normal), x) };
    let give = tool.give(body, surface, normal);
    const force = c.efcAddress >= 0 ? engine.normalForce(index) : 0;
    if (tool.moves(object)) {
      const otherRadius = this.radiusOf(other);
      told.point = difference(told.point,
                              tool.pointOn(object, add(beyond, -otherRadius, normal), x));
      const apart = radius + c.dist + otherRadius;
      if (radius > 0 && otherRadius > 0 && apart >= LEAST_APART &&
          told.point.jacobian.length <= MOST_CURVED) {
        told.curvature = sphereCurvature(normal, apart);
      }
      give += tool.give(object, beyond, normal);
    } else {
      if (radius > 0 && told.point.jacobian.length <= MOST_CURVED) {
        const curvature = this.curvatureOf(other, normal, beyond, c.dist + radius);
        if (curvature) told.curvature = curvature;
      }
      const way = this.surroundings.object(object, beyond, force, told);
      if (way) pushed.push(way);
    }
    if (radius === 0) told.point.second = [];  // the place of contact moves along the tool
    told.stiffness = 1 / (1 / new ContactSpring(engine, c).stiffness(-told.gap) + give);
    const from = add(surface, -1, vectorAt(engine.view("geom_xpos"), 3 * geom));
    told.id = this.ids.id(pairOf(c), intoFrame(engine.view("geom_xmat"), 9 * geom, from));
    return { contact: told, force };
  }

  /** How far the surface is from the point or line that carries it: a round geom's radius. */
  private radiusOf(geom: number): number {
    const { mjGEOM_SPHERE, mjGEOM_CAPSULE } = this.engine.mj.mjtGeom;
    const { geomType, geomSize } = this.engine.fixed, type = geomType[geom];
    return type === mjGEOM_SPHERE.value || type === mjGEOM_CAPSULE.value ? geomSize[3 * geom]! : 0;
  }

  /** Curvature of the object's gap to the centre of a round part of the tool, `fromSurface` away
   * from it; undefined: flat. */
  private curvatureOf(geom: number, normal: Vector3, surface: Vector3,
                      fromSurface: number): Curvature3 | undefined {
    const { mj: { mjtGeom }, fixed } = this.engine, type = fixed.geomType[geom];
    const [radius, half] = fixed.geomSize.slice(3 * geom, 3 * geom + 2) as [number, number];
    if (radius + fromSurface < LEAST_APART) return undefined;
    if (type === mjtGeom.mjGEOM_SPHERE.value) return sphereCurvature(normal, radius + fromSurface);
    const capsule = type === mjtGeom.mjGEOM_CAPSULE.value;
    if (!capsule && type !== mjtGeom.mjGEOM_CYLINDER.value) return undefined;
    const frame = this.engine.view("geom_xmat"), at = 9 * geom;
    const axis: Vector3 = [frame[at + 2]!, frame[at + 5]!, frame[at + 8]!];
    const from = add(surface, -1, vectorAt(this.engine.view("geom_xpos"), 3 * geom));
    const beside = Math.abs(dot(axis, from)) < half && Math.abs(dot(axis, normal)) < 1e-3;
    if (beside) return cylinderCurvature(normal, axis, radius + fromSurface);
    return capsule ? sphereCurvature(normal, radius + fromSurface) : undefined;
  }
}
