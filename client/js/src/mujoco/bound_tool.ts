/** The bindings of a tool, found in its model: which bodies they move, and how a point of these
 * moves with the device's coordinates. */
import { pointOnPose } from "../contact.js";
import type { PointMap } from "../contact.js";
import { countOf } from "./binding.js";
import type { Binding } from "./binding.js";
import type { Engine } from "./engine.js";
import type { ToolOptions } from "./options.js";
import { findPlace, positionOf, refuse, refuseStiff, turnOf } from "./places.js";
import type { Place } from "./places.js";
import { add, cross, dot } from "../vectors.js";
import type { Vector3 } from "../vectors.js";
import { intoFrame, MOST_CURVED, triangle, vectorAt } from "./vectors.js";

const SHORTEST = 1e-3;           // of a quaternion

/** The joints that move a body, from it to the base. */
interface Path {
  joints: Place[];
  /** A point or pose. */
  frame?: Place;
  /** Joints of the tool's own that have a spring. */
  soft: number[];
}

export class BoundTool {
  readonly places: Place[] = [];
  /** One beyond the last coordinate that is bound. */
  coordinates = 0;
  private readonly placeOfJoint = new Map<number, Place>();
  private readonly frameOfBody = new Map<number, Place>();
  private readonly paths: Path[] = [];
  private readonly owned: boolean[];

  /** Makes what Tool makes, but changes nothing. After mj_forward. */
  constructor(private readonly engine: Engine, bindings: Binding[], options: ToolOptions) {
    const { model, fixed } = engine;
    if (!(options.coupling > 0)) {
      throw new RangeError(`coupling ${options.coupling}: must be above 0 (N/m, or N m/rad)`);
    }
    for (const binding of bindings) this.add(findPlace(engine, binding));
    const taken = new Set<number>();
    for (const place of this.places) {
      const first = place.binding.firstCoordinate;
      for (let i = first; i < first + countOf(place.binding.kind); ++i) {
        if (taken.has(i)) refuse(place.binding, `coordinate ${i} is bound twice`);
        taken.add(i);
        const weight = options.weights ? options.weights[i] : 1;
        if (weight === undefined) {
          refuse(place.binding,
                 `coordinate ${i} has no weight: there are ${options.weights!.length}`);
        }
        if (!(weight > 0)) {
          refuse(place.binding, `the weight of coordinate ${i} must be above 0, not ${weight}`);
        }
        refuseStiff(engine, place, i, options.coupling * weight);
      }
    }
    this.owned = Array<boolean>(model.nv).fill(false);
    for (let body = 0; body < model.nbody; ++body) {
      this.paths.push(this.pathOf(body));
      if (!this.moves(body)) continue;
      const first = fixed.bodyDof[body]!;
      this.owned.fill(true, first, first + fixed.bodyDofs[body]!);
    }
  }

  moves(body: number): boolean {
    const { frame, joints } = this.paths[body]!;
    return frame !== undefined || joints.length > 0;
  }
  /** DoFs below a bound body: those of bindings, and those that are the tool's own. */
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
    const { joints, frame } = this.paths[body]!;
    if (joints.length === 0 && frame) return this.byFrame(frame, position, x);
    const all = frame ? [...joints, frame] : joints;
    const low = Math.min(...all.map(({ binding }) => binding.firstCoordinate));
    const high = Math.max(...all.map(
      ({ binding }) => binding.firstCoordinate + countOf(binding.kind)));
    const jacobian = Array.from({ length: high - low }, (): Vector3 => [0, 0, 0]);
    const map: PointMap = { firstCoordinate: low, position, jacobian, second: [] };
    if (frame) {
      const moved = this.byFrame(frame, position, x);
      moved.jacobian.forEach((way, i) => { jacobian[moved.firstCoordinate - low + i] = way; });
    }
    const axis = ({ id, binding }: Place): Vector3 =>
      add([0, 0, 0], binding.scale, vectorAt(this.engine.view("xaxis"), 3 * id));
    for (const joint of joints) {
      const arm = add(position, -1, vectorAt(this.engine.view("xanchor"), 3 * joint.id));
      jacobian[joint.binding.firstCoordinate - low] =
        joint.turns ? cross(axis(joint), arm) : axis(joint);
    }
    if (frame || high - low > MOST_CURVED) return map;
    map.second = Array.from({ length: triangle(high - low, 0) }, (): Vector3 => [0, 0, 0]);
    joints.forEach(({ binding: { firstCoordinate: outer } }, k) => {
      for (const inner of joints.slice(k)) {  // nearer to the base
        if (!inner.turns) continue;
        map.second[triangle(outer - low, inner.binding.firstCoordinate - low)] =
          cross(axis(inner), jacobian[outer - low]!);
      }
    });
    return map;
  }

  /** Sum of (n . J)^2 / stiffness over joints with a spring between the binding and this point: how
   * far a force of 1 N along n bends the tool itself, m/N. */
  give(body: number, position: Vector3, normal: Vector3): number {
    const { soft } = this.paths[body]!, { mj, model, fixed } = this.engine;
    if (soft.length === 0) return 0;
    const { linear: J } = this.engine.jacobian(body, position), nv = model.nv;
    let sum = 0;
    for (const joint of soft) {
      const type = fixed.jointType[joint];
      const dofs = type === mj.mjtJoint.mjJNT_FREE.value ? 6
        : type === mj.mjtJoint.mjJNT_BALL.value ? 3 : 1;
      for (let k = fixed.jointDof[joint]!; k < fixed.jointDof[joint]! + dofs; ++k) {
        const along = dot(normal, [J[k]!, J[nv + k]!, J[2 * nv + k]!]);
        sum += along * along / model.jnt_stiffness[joint];
      }
    }
    return sum;
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
    const { id, body, binding } = place;
    if (binding.kind === "joint") {
      this.placeOfJoint.set(id, place);
    } else {
      if (this.frameOfBody.has(body)) {
        refuse(binding, "its body has two points or poses; one of them must do");
      }
      this.frameOfBody.set(body, place);
    }
    this.coordinates = Math.max(this.coordinates,
                                binding.firstCoordinate + countOf(binding.kind));
    this.places.push(place);
  }

  private pathOf(body: number): Path {
    const { fixed, model } = this.engine;
    const found: Path = { joints: [], soft: [] };
    let pending: number[] = [];
    const reached = (): void => {  // the springs so far are between a binding and the body
      found.soft.push(...pending);
      pending = [];
    };
    for (; body > 0; body = fixed.bodyParent[body]!) {
      const frame = this.frameOfBody.get(body);
      if (frame) {
        reached();
        found.frame = frame;
        break;
      }
      for (let k = fixed.bodyJoints[body]! - 1; k >= 0; --k) {
        const joint = fixed.bodyJoint[body]! + k, bound = this.placeOfJoint.get(joint);
        if (bound) {
          reached();
          found.joints.push(bound);
        } else if (model.jnt_stiffness[joint] > 0) {
          pending.push(joint);
        }
      }
    }
    return found;
  }
}
