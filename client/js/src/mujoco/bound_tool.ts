/** The bindings of a tool, found in its model: which bodies they move, themselves and by way of its
 * constraints, and how a point of these moves with the device's coordinates. */
import { pointOnPose } from "../contact.js";
import type { PointMap } from "../contact.js";
import { countOf } from "./binding.js";
import type { Binding } from "./binding.js";
import { CoupledDofs } from "./coupled_dofs.js";
import type { Engine } from "./engine.js";
import type { ToolOptions } from "./options.js";
import { findPlace, positionOf, refuse, refuseStiff, turnOf } from "./places.js";
import type { Place } from "./places.js";
import { add, cross, dot } from "../vectors.js";
import type { Vector3 } from "../vectors.js";
import { intoFrame, MOST_CURVED, triangle, vectorAt } from "./vectors.js";

const SHORTEST = 1e-3;           // of a quaternion
const FOLLOWS = 10;              // stiffness of a follower, per the coupling's
const BEYOND = 1e9;              // m, longer than any tendon

/** All that moves a body, from it to the base. */
interface Path {
  /** That move. */
  dofs: number[];
  /** A point or pose. */
  frame?: Place;
}

export class BoundTool {
  /** Without second joints of a coordinate, which are coupled.followers. */
  readonly places: Place[] = [];
  readonly coupled: CoupledDofs;
  /** One beyond the last coordinate that is bound. */
  coordinates = 0;
  private readonly seconds: Place[] = [];
  private readonly frameOfBody = new Map<number, Place>();
  private moved: boolean[] = [];
  private owned: boolean[] = [];

  /** Makes what Tool makes, and changes nothing but the armature of followers. After
   * mj_forward; the data's constraints are not the model's until the next. Until look() the
   * tool is all that constraints may ever move. */
  constructor(private readonly engine: Engine, bindings: Binding[], options: ToolOptions) {
    const { model, fixed, mj, data } = engine;
    this.coupled = new CoupledDofs(engine);
    if (!(options.coupling > 0)) {
      throw new RangeError(`coupling ${options.coupling}: must be above 0 (N/m, or N m/rad)`);
    }
    for (const binding of bindings) this.add(findPlace(engine, binding));
    const taken = new Set<number>(), weights = options.weights;
    for (const place of this.places) {
      const first = place.binding.firstCoordinate;
      for (let i = first; i < first + countOf(place.binding.kind); ++i) {
        if (taken.has(i)) refuse(place.binding, `coordinate ${i} is bound twice`);
        taken.add(i);
        const weight = weights ? weights[i] : 1;
        if (weight === undefined) {
          refuse(place.binding, `coordinate ${i} has no weight: there are ${weights!.length}`);
        }
        if (!(weight > 0)) {
          refuse(place.binding, `the weight of coordinate ${i} must be above 0, not ${weight}`);
        }
        refuseStiff(engine, place, i, options.coupling * weight);
      }
    }
    for (const one of this.seconds) {
      this.follow(one, options.coupling * (weights?.[one.binding.firstCoordinate] ?? 1));
    }
    for (const { binding, body: bound } of this.places) {
      if (binding.kind === "joint") continue;
      for (let body = bound; body > 0; body = fixed.bodyParent[body]!) {
        for (let k = 0; k < fixed.bodyDofs[body]!; ++k) {
          this.coupled.leaveOut(fixed.bodyDof[body]! + k);
        }
      }
    }
    // Tendons make rows if they are beyond their limits.
    const ranges = model.tendon_range.slice();
    model.tendon_range.fill(BEYOND);
    mj.mj_fwdPosition(model, data);
    this.coupled.look(this.coordinates, true);
    model.tendon_range.set(ranges);
    this.findMoved();
  }

  /** Finds what constraints move now. After mj_forward or mj_step. */
  look(): void {
    this.coupled.look(this.coordinates);
    this.findMoved();
  }
  moves(body: number): boolean {
    return this.moved[body]!;
  }
  /** DoFs of bodies that it moves. */
  ownsDof(dof: number): boolean {
    return this.owned[dof]!;
  }
  /** True if each pose's quaternion in x is one: not so short, 1e-3, or long that it is none. */
  hasTurns(x: number[]): boolean {
    return this.places.every(({ binding: { kind, firstCoordinate: first } }) => {
      if (kind !== "pose") return true;
      const length = Math.hypot(...x.slice(first + 3, first + 7));
      return length >= SHORTEST && Number.isFinite(length);
    });
  }

  /** Writes the bound coordinates into x, angles and quaternions as near to what x holds as they
   * can be said. Needs mj_kinematics. */
  read(x: number[]): void {
    const { fixed } = this.engine, qpos = this.engine.view("qpos");
    for (const place of this.places) {
      const { kind, firstCoordinate: first, offset, scale } = place.binding;
      if (kind === "joint") {
        const here = (qpos[fixed.jointPos[place.id]!]! - offset) / scale;
        x[first]! += place.apart(x[first]!, here);
        continue;
      }
      positionOf(this.engine, place).forEach((value, k) => { x[first + k] = value; });
      if (kind === "point") continue;
      const [w, ...v] = turnOf(this.engine, place), q = [...v, w];
      const same = q.reduce((sum, part, k) => sum + part * x[first + 3 + k]!, 0);
      q.forEach((part, k) => { x[first + 3 + k] = same < 0 ? -part : part; });
    }
  }

  /** A point of `body`, which is the tool's, in the world; needs mj_kinematics, mj_comPos. With
   * second derivatives if one pose alone or only joints move it, of at most 8 coordinates. */
  pointOn(body: number, position: Vector3, x: number[]): PointMap {
    const { dofs, frame } = this.pathOf(body), { fixed, mj, model: { nv } } = this.engine;
    if (dofs.length === 0 && frame) return this.byFrame(frame, position, x);
    const ways = dofs.map((dof) => this.coupled.way(dof)!);
    const used = ways.flatMap((way) => [...way.keys()].filter((c) => way[c] !== 0));
    if (frame) {
      const { firstCoordinate, kind } = frame.binding;
      used.push(firstCoordinate, firstCoordinate + countOf(kind) - 1);
    }
    const low = used.length > 0 ? Math.min(...used) : 0, high = Math.max(-1, ...used) + 1;
    const jacobian = Array.from({ length: high - low }, (): Vector3 => [0, 0, 0]);
    const map: PointMap = { firstCoordinate: low, position, jacobian, second: [] };
    if (frame) {
      const moved = this.byFrame(frame, position, x);
      moved.jacobian.forEach((way, i) => { jacobian[moved.firstCoordinate - low + i] = way; });
    }
    const { linear: J } = this.engine.jacobian(body, position);
    const columns = dofs.map((dof): Vector3 => [J[dof]!, J[nv + dof]!, J[2 * nv + dof]!]);
    ways.forEach((way, k) => jacobian.forEach((all, c) => {
      jacobian[c] = add(all, way[low + c]!, columns[k]!);
    }));
    const { mjJNT_HINGE: { value: hinge }, mjJNT_SLIDE: { value: slide } } = mj.mjtJoint;
    const types = dofs.map((dof) => fixed.jointType[fixed.dofJoint[dof]!]!);
    const simple = types.every((type) => type === hinge || type === slide);
    if (frame || high - low > MOST_CURVED || !simple) return map;
    map.second = Array.from({ length: triangle(high - low, 0) }, (): Vector3 => [0, 0, 0]);
    dofs.forEach((_, outer) => {
      for (let inner = outer; inner < dofs.length; ++inner) {  // nearer to the base
        if (types[inner] !== hinge) continue;
        const axis = vectorAt(this.engine.view("xaxis"), 3 * fixed.dofJoint[dofs[inner]!]!);
        const bend = cross(axis, columns[outer]!), [a, b] = [ways[outer]!, ways[inner]!];
        for (let i = low; i < high; ++i) {
          for (let k = low; k <= i; ++k) {
            const share = a[i]! * b[k]! + (outer === inner ? 0 : b[i]! * a[k]!);
            const at = triangle(i - low, k - low);
            map.second[at] = add(map.second[at]!, share, bend);
          }
        }
      }
    });
    return map;
  }

  /** How far a force of 1 N along n at this point bends the tool's own joints, m/N: their springs,
   * and the rows that lead them. */
  give(body: number, position: Vector3, normal: Vector3): number {
    const { linear: J } = this.engine.jacobian(body, position), { nv } = this.engine.model;
    return this.coupled.give((dof) =>
      this.owned[dof] ? dot(normal, [J[dof]!, J[nv + dof]!, J[2 * nv + dof]!]) : 0);
  }

  /** A point that a point or pose carries with it. */
  private byFrame(frame: Place, position: Vector3, x: number[]): PointMap {
    const { kind, firstCoordinate } = frame.binding;
    if (kind === "point") {
      return { firstCoordinate, position, jacobian: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], second: [] };
    }
    const from = add(position, -1, positionOf(this.engine, frame));
    const turn = this.engine.view(frame.site ? "site_xmat" : "xmat");
    const offset = intoFrame(turn, 9 * frame.id, from);
    return pointOnPose(x, offset, firstCoordinate);
  }

  private add(place: Place): void {
    const { body, binding, dofs } = place, { firstCoordinate: first, kind } = binding;
    this.coordinates = Math.max(this.coordinates, first + countOf(kind));
    if (kind === "joint") {
      if (this.coupled.bound(dofs[0]!)) refuse(binding, "the joint is bound twice");
      this.coupled.bind(dofs[0]!, first, binding.scale);
    } else {
      if (this.frameOfBody.has(body)) {
        refuse(binding, "its body has two points or poses; one of them must do");
      }
      this.frameOfBody.set(body, place);
    }
    const second = kind === "joint" && this.places.some(({ binding: other }) =>
      other.kind === "joint" && other.firstCoordinate === first);
    (second ? this.seconds : this.places).push(place);
  }

  private follow({ binding, dofs, id, mass: own }: Place, spring: number): void {
    const { fixed, model, opt: { timestep: step } } = this.engine, { scale } = binding;
    const leader = this.places.find(
      (other) => other.binding.firstCoordinate === binding.firstCoordinate)!;
    // The spring is as stiff as both masses allow in a step. A light joint gets armature.
    const stiffness = Math.min(FOLLOWS * spring, 0.1 * leader.mass / (step * step));
    const mass = Math.max(own, 4 * step * step * stiffness), square = scale * scale;
    model.dof_armature[dofs[0]!] += (mass - own) / square;
    const together = 1 / (1 / mass + 1 / leader.mass), ratio = scale / leader.binding.scale;
    this.coupled.follow({
      dof: dofs[0]!, position: fixed.jointPos[id]!, leader: leader.dofs[0]!,
      leaderPosition: fixed.jointPos[leader.id]!, ratio,
      offset: binding.offset - ratio * leader.binding.offset, stiffness: stiffness / square,
      damping: 2 * Math.sqrt(stiffness * together) / square,
    });
    leader.mass += mass;
  }

  private findMoved(): void {
    const { fixed, model: { nbody, nv } } = this.engine, { coupled } = this;
    const firm = [true], carried = [false];  // with all that is between a body and the base
    this.moved = [false];
    this.owned = Array<boolean>(nv).fill(false);
    for (let body = 1; body < nbody; ++body) {
      const parent = fixed.bodyParent[body]!, first = fixed.bodyDof[body]!;
      const dofs = Array.from({ length: fixed.bodyDofs[body]! }, (_, k) => first + k);
      const below = this.moved[parent]! || this.frameOfBody.has(body) ||
        dofs.some((dof) => coupled.bound(dof));
      firm[body] = firm[parent]! && dofs.every((dof) => coupled.firm(dof));
      carried[body] = carried[parent]! || dofs.some((dof) => coupled.way(dof) !== undefined);
      this.moved[body] = below || (firm[body]! && carried[body]!);
      if (this.moved[body]) for (const dof of dofs) this.owned[dof] = true;
    }
  }

  private pathOf(body: number): Path {
    const { fixed } = this.engine, found: Path = { dofs: [] };
    for (; body > 0; body = fixed.bodyParent[body]!) {
      const frame = this.frameOfBody.get(body);
      if (frame) return { ...found, frame };
      const first = fixed.bodyDof[body]!;
      for (let dof = first + fixed.bodyDofs[body]! - 1; dof >= first; --dof) {
        if (this.coupled.way(dof)) found.dofs.push(dof);
      }
    }
    return found;
  }
}
