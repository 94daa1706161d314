/** MuJoCo's WebAssembly build, with numbers instead of handles. A view of its memory holds until
 * that grows, which any call may do: take it again after each. */
import type { MainModule, MjData, MjModel } from "@mujoco/mujoco";
import type { Vector3 } from "../vectors.js";
import { add, cross } from "../vectors.js";
import { vectorAt } from "./vectors.js";

export type { MainModule, MjData, MjModel } from "@mujoco/mujoco";

/** The part of mjContact that is used. */
export interface EngineContact {
  geom1: number;
  geom2: number;
  dist: number;
  includemargin: number;
  exclude: number;
  dim: number;
  efcAddress: number;
  pos: Vector3;
  /** From geom1 to geom2. */
  normal: Vector3;
  friction: number[];
  solref: number[];
  solimp: number[];
}

/** Values that a model keeps for its life; they are read once. */
function constants(model: MjModel) {
  const copy = (view: ArrayLike<number>): number[] => Array.from(view);
  return {
    bodyParent: copy(model.body_parentid), bodyRoot: copy(model.body_rootid),
    bodyWeld: copy(model.body_weldid), bodyDofs: copy(model.body_dofnum),
    bodyDof: copy(model.body_dofadr), bodyJoints: copy(model.body_jntnum),
    bodyJoint: copy(model.body_jntadr), bodyInvweight: copy(model.body_invweight0),
    dofParent: copy(model.dof_parentid), dofJoint: copy(model.dof_jntid),
    dofInvweight: copy(model.dof_invweight0), geomBody: copy(model.geom_bodyid),
    geomType: copy(model.geom_type), geomSize: copy(model.geom_size),
    jointBody: copy(model.jnt_bodyid), jointType: copy(model.jnt_type),
    jointDof: copy(model.jnt_dofadr), jointPos: copy(model.jnt_qposadr),
    siteBody: copy(model.site_bodyid), siteQuat: copy(model.site_quat),
  };
}

export class Engine {
  readonly fixed: ReturnType<typeof constants>;
  /** The model's own, taken once: each look at model.opt makes a handle. */
  readonly opt: MjModel["opt"];
  private readonly linear: Float64Array;
  private readonly angular: Float64Array;
  /** Views of data; see view(). */
  private readonly views = new Map<keyof MjData, Float64Array>();
  private readonly M;
  private readonly solved;
  private readonly force;

  /** All stay the caller's, and must live longer. */
  constructor(readonly mj: MainModule, readonly model: MjModel, readonly data: MjData) {
    this.fixed = constants(model);
    this.opt = model.opt;
    this.linear = new Float64Array(3 * model.nv);
    this.angular = new Float64Array(3 * model.nv);
    this.M = new mj.DoubleBuffer(model.nv * model.nv);
    this.solved = new mj.DoubleBuffer(6 * model.nv);
    this.force = new mj.DoubleBuffer(6);
  }
  /** WebAssembly's memory is not collected. */
  delete(): void {
    const { M, solved, force, opt } = this;
    for (const one of [M, solved, force, opt]) one.delete();
  }

  /** Name by which a person finds it in the model. */
  nameOfGeom(geom: number): string {
    const own = this.nameOf("GEOM", geom);
    if (own) return `geom '${own}'`;
    const body = this.nameOf("BODY", this.fixed.geomBody[geom]!);
    return body ? `geom ${geom} of body '${body}'` : `geom ${geom}`;
  }
  /** Empty: it has none. */
  nameOf(type: "ACTUATOR" | "BODY" | "GEOM" | "JOINT", id: number): string {
    const name = this.mj.mj_id2name(this.model, this.mj.mjtObj[`mjOBJ_${type}`].value, id) ?? "";
    return this.idOf(type, name) === id ? name : "";  // 3.14.0 gives nonsense if it has none
  }
  /** -1: there is none. */
  idOf(type: "ACTUATOR" | "BODY" | "GEOM" | "JOINT" | "SITE" | "NUMERIC", name: string): number {
    return this.mj.mj_name2id(this.model, this.mj.mjtObj[`mjOBJ_${type}`].value, name);
  }
  /** An array of numbers that data keeps at one place for its life: looking at data.qpos takes a
   * microsecond. Until the next call into MuJoCo. */
  view(name: keyof MjData): Float64Array {
    let view = this.views.get(name);
    if (!view?.length) this.views.set(name, view = this.data[name] as Float64Array);  // it grew
    return view;
  }
  /** d position / d qpos of a point of `body`, and of its turn: 3 x nv each, till the next call.
   * It computes what mj_jac does; a call of that takes longer than its work. */
  jacobian(body: number, position: Vector3): { linear: Float64Array; angular: Float64Array } {
    const { linear, angular, fixed: { bodyDof, bodyDofs, bodyParent, bodyRoot, dofParent } } = this;
    const nv = linear.length / 3, axes = this.view("cdof");
    const from = add(position, -1, vectorAt(this.view("subtree_com"), 3 * bodyRoot[body]!));
    linear.fill(0);
    angular.fill(0);
    while (body > 0 && bodyDofs[body] === 0) body = bodyParent[body]!;
    if (body === 0) return { linear, angular };
    for (let i = bodyDof[body]! + bodyDofs[body]! - 1; i >= 0; i = dofParent[i]!) {
      const turn = vectorAt(axes, 6 * i), moved = cross(turn, from);
      for (let k = 0; k < 3; ++k) {
        angular[k * nv + i] = turn[k]!;
        linear[k * nv + i] = axes[6 * i + 3 + k]! + moved[k]!;
      }
    }
    return { linear, angular };
  }
  /** M, nv x nv, until the next call. */
  masses(): Float64Array {
    this.mj.mj_fullM(this.model, this.data, this.M);
    return this.M.GetView() as Float64Array;
  }
  /** M^-1 times each of the 6 rows of J, until the next call. */
  overMass(J: Float64Array): Float64Array {
    this.mj.mj_solveM(this.model, this.data, this.solved, J as unknown as number[]);
    return this.solved.GetView() as Float64Array;
  }
  /** N, along the normal of contact i. */
  normalForce(i: number): number {
    this.mj.mj_contactForce(this.model, this.data, i, this.force);
    return (this.force.GetView() as Float64Array)[0]!;
  }
  /** How often MuJoCo began again because of a bad state, since the data began. */
  badStates(): number {
    const { mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC } = this.mj.mjtWarning;
    return [mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC].reduce(
      (sum, warning) => sum + this.warnings(warning.value), 0);
  }
  warnings(type: number): number {
    const one = this.data.warning.get(type)!;  // a copy, of the data's own list
    const { number } = one;
    one.delete();
    return number;
  }
  /** Those that the last mj_step or mj_forward found. */
  contacts(): EngineContact[] {
    const list = this.data.contact, found: EngineContact[] = [];
    for (let i = 0; i < list.size(); ++i) {
      const c = list.get(i)!;
      found.push({
        geom1: c.geom1, geom2: c.geom2, dist: c.dist, includemargin: c.includemargin,
        exclude: c.exclude, dim: c.dim, efcAddress: c.efc_address, pos: vectorAt(c.pos),
        normal: vectorAt(c.frame), friction: Array.from(c.friction), solref: Array.from(c.solref),
        solimp: Array.from(c.solimp),
      });
      c.delete();
    }
    list.delete();
    return found;
  }
}
