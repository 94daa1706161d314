/** DoFs of a model that move with the bound joints, because its constraints say so. */
import { rowsOf } from "./constraint_rows.js";
import type { Engine } from "./engine.js";
import { Skyline } from "../skyline.js";
import { along } from "../vectors.js";

const LOOSE = 0.01;       // 1/s^2: what holds a mass that nothing else does
const LEAST_WAY = 1e-6;   // smaller is the rows' softness
const LED = 0.02;         // share of a load that does not go into the rows

/** A second joint of a coordinate. A spring of the tool's keeps it where the first one, its leader,
 * says: both as one against the probe. */
export interface Follower {
  dof: number;
  position: number;        // in qpos
  leader: number;          // a DoF
  leaderPosition: number;
  /** qpos = offset + ratio times the leader's. */
  ratio: number;
  offset: number;
  stiffness: number;       // N m/rad
  damping: number;
}
interface Row {
  parts: [dof: number, value: number][];
  stiffness: number;
}

/** Rows A of equalities (mimic joints, closed chains, welds), and of tendons and joints that are at
 * their limit, connect bound DoFs b with others, u. Held still, these follow by
 *
 *   du/dx = -H^-1 A_u^T k A_b db/dx,  H = A_u^T k A_u + K,
 *
 * with the rows' stiffness k, and K of the joints' springs. With rows much stiffer than springs
 * that is -A_u^+ A_b. What nothing holds is held by next to nothing of its mass. */
export class CoupledDofs {
  readonly followers: Follower[] = [];
  private readonly roots: number[] = [];  // of each DoF: the first one of its tree
  private readonly masses: number[] = [];
  private readonly springs: number[] = [];
  private readonly boundTo = new Map<number, { coordinate: number; scale: number }>();
  private readonly leftOut = new Set<number>();
  private rows: Row[] = [];
  private dofs: number[] = [];            // u
  private place = new Map<number, number>();
  private ways = new Map<number, Float64Array>();
  /** DoFs that some row leads, at times, if it is a tendon's. */
  private readonly slack = new Set<number>();
  private held: boolean[] = [];
  private guided: boolean[] = [];
  private readonly H = new Skyline();

  constructor(private readonly engine: Engine) {
    const { fixed, model } = engine;
    const masses: Float64Array = model.dof_M0, springs: Float64Array = model.jnt_stiffness;
    fixed.dofJoint.forEach((joint, i) => {
      this.roots.push(fixed.dofParent[i]! < 0 ? i : this.roots[fixed.dofParent[i]!]!);
      this.masses.push(LOOSE * masses[i]!);
      this.springs.push(springs[joint]!);
    });
  }
  /** A DoF moves by `scale` per unit of a coordinate. */
  bind(dof: number, coordinate: number, scale: number): void {
    this.boundTo.set(dof, { coordinate, scale });
  }
  /** It is pulled by a point or pose: rows do not count there. */
  leaveOut(dof: number): void {
    if (!this.bound(dof)) this.leftOut.add(dof);
  }
  /** Its DoF, which was bound, is led by a row from now on. */
  follow(follower: Follower): void {
    this.followers.push(follower);
    this.boundTo.delete(follower.dof);
  }
  bound(dof: number): boolean {
    return this.boundTo.has(dof);
  }
  /** d qpos of a DoF / dx, per coordinate; undefined: it does not move. */
  way(dof: number): Float64Array | undefined {
    return this.ways.get(dof);
  }
  /** Bindings, rows or springs say where it is. */
  firm(dof: number): boolean {
    return this.held[dof]!;
  }
  /** It moves, and rows alone say where it is: its own spring does not count. */
  led(dof: number): boolean {
    return this.guided[dof]!;
  }

  /** Reads the rows of the last mj_forward or mj_step. Those of tendons and joints count if they
   * push; `ever`: of tendons, if they leave little room, whether they push or not. */
  look(coordinates: number, ever = false): void {
    const { H, masses, place, springs } = this;
    this.findRows(ever);
    H.begin(this.dofs.length);
    this.dofs.forEach((_, i) => H.reach(i, 0));
    this.dofs.forEach((dof, i) => H.add(i, i, springs[dof]! + masses[dof]!));
    for (const { parts, stiffness } of this.rows) {
      const all = parts.map(([dof, value]) => [place.get(dof) ?? -1, value] as const);
      for (const [i, to] of all) {
        for (const [k, from] of all) if (k >= 0 && k <= i) H.add(i, k, stiffness * to * from);
      }
    }
    H.factor(this.engine.mj.mjMINVAL);
    this.findWays(coordinates);
    this.findFirm();
    if (ever) this.guided.forEach((led, dof) => { if (led) this.slack.add(dof); });
  }

  /** Adds to `applied` what takes weight and passive forces of DoFs that move off the rows, and so
   * off the bound ones; of `owned` DoFs also while a tendon that leads them is slack. */
  takeOff(applied: Float64Array, owned: (dof: number) => boolean): void {
    const bias = this.engine.view("qfrc_bias"), passive = this.engine.view("qfrc_passive");
    // The forces, and then what the rows do not take of them.
    const left = Float64Array.from(this.dofs, (dof) => passive[dof]! - bias[dof]!);
    this.H.solve(left);
    this.masses.forEach((mass, dof) => {
      const slack = this.slack.has(dof) && owned(dof);
      if (this.bound(dof) || !(this.ways.has(dof) || slack)) return;
      applied[dof]! += bias[dof]! - passive[dof]!;
      if (!slack) applied[dof]! += (this.springs[dof]! + mass) * left[this.place.get(dof)!]!;
    });
  }
  /** v^T H^-1 v over the firm DoFs that are not bound; `v`: of a DoF. */
  give(v: (dof: number) => number): number {
    const load = new Float64Array(this.dofs.length);
    let sum = 0;
    this.springs.forEach((spring, dof) => {
      if (!this.firm(dof) || this.bound(dof) || this.leftOut.has(dof)) return;
      const i = this.place.get(dof);
      if (i === undefined) sum += v(dof) ** 2 / spring;
      else load[i] = v(dof);
    });
    const u = load.slice();
    this.H.solve(u);
    return sum + along(load, u);
  }

  private findRows(ever: boolean): void {
    const read = rowsOf(this.engine, []), all: Row[] = [];
    for (let i = 0; i < read.count; ++i) {
      if (!read.couples(i, ever)) continue;
      const row: Row = { parts: [],
                         stiffness: read.KBIP[4 * i]! * read.KBIP[4 * i + 2]! / read.R[i]! };
      read.forParts(i, (dof, value) => row.parts.push([dof, value]));
      all.push(row);
    }
    for (const { leader, ratio, dof, stiffness } of this.followers) {
      all.push({ parts: [[leader, -ratio], [dof, 1]], stiffness });
    }
    this.rows = [];
    // Reached from a bound DoF, by rows.
    const trees = new Set([...this.boundTo.keys()].map((dof) => this.roots[dof]!));
    const held = new Set<number>();
    for (let more = true; more;) {
      more = false;
      for (const row of all) {
        if (!row.parts.some(([dof]) => trees.has(this.roots[dof]!))) continue;
        for (const [dof] of row.parts) {
          held.add(dof);
          trees.add(this.roots[dof]!);
        }
        this.rows.push({ ...row });
        row.parts = [];
        more = true;
      }
    }
    this.dofs = [...held].filter((dof) => !this.bound(dof) && !this.leftOut.has(dof));
    this.dofs.sort((a, b) => a - b);
    this.place.clear();
    this.dofs.forEach((dof, i) => this.place.set(dof, i));
  }

  private findWays(coordinates: number): void {
    this.ways.clear();
    const of = (dof: number): Float64Array => {
      let way = this.ways.get(dof);
      if (!way) this.ways.set(dof, way = new Float64Array(coordinates));
      return way;
    };
    for (const [dof, { coordinate, scale }] of this.boundTo) of(dof)[coordinate] = scale;
    for (const c of new Set([...this.boundTo.values()].map(({ coordinate }) => coordinate))) {
      const u = new Float64Array(this.dofs.length);
      let any = false;
      for (const { parts, stiffness } of this.rows) {
        let there = 0;
        for (const [dof, value] of parts) if (this.bound(dof)) there += value * of(dof)[c]!;
        any ||= there !== 0;
        for (const [dof, value] of parts) {
          const i = this.place.get(dof);
          if (i !== undefined) u[i]! -= stiffness * value * there;
        }
      }
      if (!any) continue;
      this.H.solve(u);
      u.forEach((way, i) => {
        if (Math.abs(way) >= LEAST_WAY) of(this.dofs[i]!)[c] = way;
      });
    }
  }

  private findFirm(): void {
    this.held = this.springs.map((spring, dof) => this.bound(dof) || spring > 0);
    this.guided = this.masses.map(() => false);
    this.dofs.forEach((dof, i) => {
      const unit = new Float64Array(this.dofs.length);
      unit[i] = 1;
      this.H.solve(unit);
      const mass = this.masses[dof]!;
      this.held[dof] = unit[i]! * mass < 0.5;
      this.guided[dof] = this.ways.has(dof) && unit[i]! * (mass + this.springs[dof]!) < LED;
    });
    for (const { dof } of this.followers) this.guided[dof] = true;
  }
}
