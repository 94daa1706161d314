/** Things that the tool touches, and what holds them. */
import type { Contact } from "../contact.js";
import type { Vector3 } from "../vectors.js";
import type { BoundTool } from "./bound_tool.js";
import { rowsOf } from "./constraint_rows.js";
import type { ConstraintRows } from "./constraint_rows.js";
import type { Engine, EngineContact } from "./engine.js";
import type { PushedObject } from "./pushed_object.js";
import { Skyline } from "../skyline.js";
import { along } from "../vectors.js";

const HOLD = 0.05;           // s, h
const OUTSIDE = -1;          // of the DoFs that count
const HEAVIEST = 1e6;        // kg; beyond, it is a wall

interface Part {
  /** In the DoFs that count. */
  i: number;
  value: number;
}
interface Row {
  /** J */
  way: Part[];
  mass: number;
  damping: number;
  stiffness: number;
  /** Force that damping and mass take now, N. */
  taken: number;
}

/** All that is not the tool: bodies with their joints' springs and dampers, and MuJoCo's other
 * constraints (a floor, friction that sticks, joint limits). Each row of these has a force
 * (a_ref - a) / R: a spring, a damper and a mass 1 / R (contact_spring.ts). Friction that slips is
 * a constant force. What the tool itself touches the server knows by its own contacts.
 *
 * An object has one law per contact, so one way to give in: u, the motion of all joints by which
 * its surface recedes by 1 under a push that lasts 50 ms, the time for which the law must hold.
 * With H = M + h D + h^2 K over joints and rows and J the surface's way, u = H^-1 J^T / (J H^-1
 * J^T). Mass, damping and stiffness are those of u, the load is u^T times all forces but this
 * contact's and but what the damping and the rows' masses take. So a box between finger and ball
 * has the ball's stiffness, and one that slides is not stiff because it cannot turn into the floor.
 *
 * Only what is touched counts, and what rows connect with it: a pile costs nothing until one of it
 * is touched, and a box alone costs as if it were alone. */
export class Surroundings {
  /** That count, tree by tree; none is the tool's. */
  private dofs: number[] = [];
  /** Where each tree begins in dofs, and the end. */
  private trees: number[] = [];
  /** Place of each DoF in dofs. */
  private place: number[] = [];
  private rows: Row[] = [];
  /** Entries of M that are not 0. */
  private M: { i: number; k: number; value: number }[] = [];
  private readonly H = new Skyline();
  /** All forces on the DoFs, and what their dampers take. */
  private push = new Float64Array(0);
  private rate: Float64Array = new Float64Array(0);
  private damping: number[] = [];
  private stiffness: number[] = [];

  constructor(private readonly engine: Engine, private readonly tool: BoundTool) {}

  /** Reads the contacts as the last mj_forward or mj_step found them. `rate`: qvel as it began, nv.
   * `bodies`: those that object() will be asked for. */
  look(contacts: EngineContact[], rate: Float64Array, bodies: Set<number>): void {
    const { fixed, model, mj } = this.engine, { H } = this;
    this.rate = rate;
    this.dofs = [];
    this.rows = [];
    this.M = [];
    const touched = new Set<number>();  // DoFs
    for (let body of bodies) {
      while (body > 0 && fixed.bodyDofs[body] === 0) body = fixed.bodyParent[body]!;
      if (body > 0) touched.add(fixed.bodyDof[body]!);
    }
    if (touched.size === 0) return;
    const all = rowsOf(this.engine, contacts);
    const counting = Array.from({ length: all.count }, (_, row) => row)
      .filter((row) => this.counts(all, row));
    this.findDofs(all, counting, [...touched].sort((a, b) => a - b));
    this.findMasses();
    const acceleration = this.engine.view("qacc");
    for (const row of counting) this.lookAtRow(all, row, acceleration);
    const n = this.dofs.length;
    H.begin(n);
    for (const { i, k } of this.M) H.reach(i, k);
    for (const { way } of this.rows) {
      const first = Math.min(...way.map(({ i }) => i));
      for (const { i } of way) H.reach(i, first);
    }
    for (const { i, k, value } of this.M) if (k <= i) H.add(i, k, value);
    const smooth = this.engine.view("qfrc_smooth");
    const constraint = this.engine.view("qfrc_constraint");
    const damping: Float64Array = model.dof_damping, springs: Float64Array = model.jnt_stiffness;
    this.damping = this.dofs.map((dof) => damping[dof]!);
    this.stiffness = this.dofs.map((dof) => springs[fixed.dofJoint[dof]!]!);
    this.push = Float64Array.from(this.dofs, (dof, i) =>
      smooth[dof]! + constraint[dof]! + this.damping[i]! * rate[dof]!);
    for (let i = 0; i < n; ++i) {
      H.add(i, i, HOLD * this.damping[i]! + HOLD * HOLD * this.stiffness[i]!);
    }
    for (const row of this.rows) {
      const weight = row.mass + HOLD * row.damping + HOLD * HOLD * row.stiffness;
      for (const a of row.way) {
        this.push[a.i]! += a.value * row.taken;
        for (const b of row.way) if (b.i <= a.i) H.add(a.i, b.i, weight * a.value * b.value);
      }
    }
    H.factor(mj.mjMINVAL);
  }

  /** Tells a contact with `body` at `position` the law along its normal: mass, damping, stiffness
   * to ground, load and velocity (proto/README.md, Objects that are pushed). `force`: of it, N.
   * Undefined: the body cannot move. */
  object(body: number, position: Vector3, force: number,
         told: Contact): PushedObject | undefined {
    const { fixed, model: { nv } } = this.engine, { dofs, rate } = this, { normal } = told;
    if (dofs.length === 0 || fixed.bodyWeld[body] === 0) return undefined;
    const { linear: J } = this.engine.jacobian(body, position);
    const recedes = Float64Array.from(dofs, (dof) =>
      -(normal[0] * J[dof]! + normal[1] * J[nv + dof]! + normal[2] * J[2 * nv + dof]!));
    if (along(recedes, recedes) === 0) return undefined;
    const motion = recedes.slice();
    this.H.solve(motion);
    const give = along(recedes, motion);
    if (!(give * HEAVIEST > 1)) return undefined;
    for (let i = 0; i < motion.length; ++i) motion[i]! /= give;
    let mass = 0, damping = 0, groundStiffness = 0;
    for (const { i, k, value } of this.M) mass += motion[i]! * value * motion[k]!;
    motion.forEach((u, i) => {
      damping += this.damping[i]! * u * u;
      groundStiffness += this.stiffness[i]! * u * u;
    });
    for (const row of this.rows) {
      let way = 0;
      for (const { i, value } of row.way) way += value * motion[i]!;
      mass += row.mass * way * way;
      damping += row.damping * way * way;
      groundStiffness += row.stiffness * way * way;
    }
    Object.assign(told, {
      mass, damping, groundStiffness, load: along(motion, this.push) - force,
      velocity: dofs.reduce((sum, dof, i) => sum + recedes[i]! * rate[dof]!, 0),
    });
    return { told, root: fixed.bodyRoot[body]!, force, recedes, motion, give };
  }

  private counts(all: ConstraintRows, row: number): boolean {
    const { geomBody } = this.engine.fixed, contact = all.contactOf(row);
    const ofTool = (geom: number) => geom >= 0 && this.tool.moves(geomBody[geom]!);
    if (contact && (ofTool(contact.geom1) || ofTool(contact.geom2))) return false;
    return all.isSpring(row);
  }

  private findDofs(all: ConstraintRows, counting: number[], touched: number[]): void {
    const { fixed, model: { nv } } = this.engine;
    const tree: number[] = [];  // of each DoF: the first DoF that moves with it
    for (let i = 0; i < nv; ++i) {
      tree.push(fixed.dofParent[i]! < 0 ? i : tree[fixed.dofParent[i]!]!);
    }
    const beside = tree.map(() => new Set<number>());  // of a tree: those that rows connect with it
    for (const row of counting) {
      let first = -1;
      all.forParts(row, (dof) => {
        if (this.tool.ownsDof(dof)) return;
        const here = tree[dof]!;
        if (first < 0) first = here;
        if (here === first) return;
        beside[first]!.add(here);
        beside[here]!.add(first);
      });
    }
    // Sorted by their way from what is touched, the nearest last: that keeps the rows of H short.
    const group = new Set(touched.map((dof) => tree[dof]!));
    for (const root of group) {
      for (const other of [...beside[root]!].sort((a, b) => a - b)) group.add(other);
    }
    this.place = Array<number>(nv).fill(OUTSIDE);
    this.trees = [];
    for (const root of [...group].reverse()) {
      this.trees.push(this.dofs.length);
      for (let i = root; i < nv && tree[i] === root; ++i) {
        if (this.tool.ownsDof(i)) continue;
        this.place[i] = this.dofs.length;
        this.dofs.push(i);
      }
    }
    this.trees.push(this.dofs.length);
  }

  private findMasses(): void {
    const { dofs, trees } = this, M = this.engine.masses(), { nv } = this.engine.model;
    trees.slice(1).forEach((end, t) => {  // none moves another's
      for (let i = trees[t]!; i < end; ++i) {
        for (let k = trees[t]!; k < end; ++k) {
          const value = M[dofs[i]! * nv + dofs[k]!]!;
          if (value !== 0) this.M.push({ i, k, value });
        }
      }
    });
  }

  private lookAtRow(all: ConstraintRows, index: number, acceleration: Float64Array): void {
    const addRow = (at: number, share: number, way: Part[]) => all.forParts(at, (dof, value) => {
      const i = this.place[dof]!;
      if (i === OUTSIDE) return;
      const same = way.find((part) => part.i === i);
      if (same) same.value += share * value;
      else way.push({ i, value: share * value });
    });
    const way: Part[] = [];
    addRow(index, 1, way);
    if (way.length === 0) return;
    const contact = all.contactOf(index), place = contact ? index - contact.efcAddress : 0;
    const K = all.KBIP[4 * index]!, B = all.KBIP[4 * index + 1]!, I = all.KBIP[4 * index + 2]!;
    const mass = 1 / all.R[index]!, damping = B * mass, stiffness = K * I * mass;
    const row: Row = { way, mass, damping, stiffness: 0, taken: 0 };
    for (const { i, value } of way) {
      const dof = this.dofs[i]!;
      row.taken += value * (damping * this.rate[dof]! + mass * acceleration[dof]!);
    }
    if (all.isEdge(index)) {
      // Two edges lie about the normal, which has the spring.
      const normal: Row = { way: [], mass: 0, damping: 0, stiffness, taken: 0 };
      addRow(index, 0.5, normal.way);
      addRow(place % 2 === 0 ? index + 1 : index - 1, 0.5, normal.way);
      this.rows.push(normal);
    } else if (place === 0) {
      row.stiffness = stiffness;
    }
    this.rows.push(row);
  }
}
