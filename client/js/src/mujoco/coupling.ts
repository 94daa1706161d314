/** Springs that pull the tool to its aim. */
import type { Aim } from "./aim.js";
import type { BoundTool } from "./bound_tool.js";
import type { Follower } from "./coupled_dofs.js";
import type { Engine } from "./engine.js";
import type { ToolOptions } from "./options.js";
import { positionOf, turnOf } from "./places.js";
import type { Place } from "./places.js";
import { conjugate, normalised, product, rateOf } from "./vectors.js";
import type { Quaternion } from "./vectors.js";

export class Coupling {
  /** Force of the springs in the last pull(), N or N m per coordinate; of a pose only its
   * position. */
  readonly pulled: number[];
  private readonly pushed = new Set<number>();  // DoFs, at any time

  constructor(private readonly engine: Engine, private readonly tool: BoundTool,
              private readonly aim: Aim, private readonly options: ToolOptions) {
    this.pulled = Array<number>(tool.coordinates).fill(0);
  }
  /** c w of a coordinate. */
  stiffness(i: number): number {
    return this.options.coupling * (this.options.weights?.[i] ?? 1);
  }

  /** Sets qfrc_applied of all DoFs that the tool pulls. `seen`: where it is, all coordinates;
   * `rate`: qvel. Needs mj_kinematics, mj_comPos. */
  pull(seen: number[], rate: Float64Array): void {
    const push = new Float64Array(rate.length), { coupled, places } = this.tool;
    const bias = this.engine.view("qfrc_bias"), passive = this.engine.view("qfrc_passive");
    for (const place of places) {
      for (const dof of place.dofs) push[dof]! += bias[dof]! - passive[dof]!;
    }
    for (const place of places) {
      if (place.binding.kind === "joint") this.pullJoint(place, seen, rate, push);
      else this.pullFrame(place, rate, push);
    }
    coupled.takeOff(push, (dof) => this.tool.ownsDof(dof));
    for (const follower of coupled.followers) this.pullFollower(follower, rate, push);
    const applied = this.engine.view("qfrc_applied");
    push.forEach((value, dof) => {  // a frame pushes its parents' DoFs, too
      if (value !== 0) this.pushed.add(dof);
      if (this.tool.ownsDof(dof) || this.pushed.has(dof)) applied[dof] = value;
    });
  }

  private pullJoint(place: Place, seen: number[], rate: Float64Array, push: Float64Array): void {
    const { firstCoordinate: i, scale } = place.binding, dof = place.dofs[0]!;
    const stiffness = this.stiffness(i);
    const faster = this.aim.rate(i) - rate[dof]! / scale;
    this.pulled[i] = stiffness * place.apart(seen[i]!, this.aim.at(i)) +
      2 * Math.sqrt(stiffness * place.mass) * faster;
    push[dof]! += this.pulled[i]! / scale;
  }
  private pullFollower(one: Follower, rate: Float64Array, push: Float64Array): void {
    const qpos = this.engine.view("qpos");
    const apart = one.offset + one.ratio * qpos[one.leaderPosition]! - qpos[one.position]!;
    const faster = one.ratio * rate[one.leader]! - rate[one.dof]!;
    const force = one.stiffness * apart + one.damping * faster;
    push[one.dof]! += force;
    push[one.leader]! -= one.ratio * force;
  }

  private pullFrame(place: Place, rate: Float64Array, push: Float64Array): void {
    const { kind, firstCoordinate: first } = place.binding;
    const { opt, model: { nv } } = this.engine;
    const position = positionOf(this.engine, place), aim = this.aim;
    const { linear, angular } = this.engine.jacobian(place.body, position);
    const speed = (jacobian: Float64Array, k: number) => {
      let sum = 0;
      for (let i = 0; i < nv; ++i) sum += jacobian[k * nv + i]! * rate[i]!;
      return sum;
    };
    const apply = (jacobian: Float64Array, k: number, force: number) => {
      for (let i = 0; i < nv; ++i) push[i]! += jacobian[k * nv + i]! * force;
    };
    for (let k = 0; k < 3; ++k) {
      const stiffness = this.stiffness(first + k);
      const force = stiffness * (aim.at(first + k) - position[k]!) +
        2 * Math.sqrt(stiffness * place.mass) * (aim.rate(first + k) - speed(linear, k));
      this.pulled[first + k] = force;
      apply(linear, k, force);
    }
    if (kind === "point") return;
    const here = turnOf(this.engine, place), i = first + 3;
    const of = (f: (i: number) => number): Quaternion =>
      normalised([f(i + 3), f(i), f(i + 1), f(i + 2)]);  // MuJoCo has w first
    const there = of((part) => aim.at(part));
    const back = of((part) => aim.at(part) - aim.rate(part) * opt.timestep);
    const turn = rateOf(product(there, conjugate(back)), opt.timestep);  // of the aim, in the world
    const error = product(there, conjugate(here));
    // Minus the gradient of c w / 2 times the squared length between the two quaternions.
    const stiffness = 0.5 * this.stiffness(i);
    const damping = 2 * Math.sqrt(0.5 * stiffness * place.inertia);
    for (let k = 0; k < 3; ++k) {
      apply(angular, k, (error[0] < 0 ? -stiffness : stiffness) * error[1 + k]! +
        damping * (turn[k]! - speed(angular, k)));
    }
  }
}
