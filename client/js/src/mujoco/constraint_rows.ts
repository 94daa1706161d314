/** MuJoCo's rows of constraints, as the last mj_forward or mj_step found them. */
import type { Engine, EngineContact } from "./engine.js";

/** Share of the cone of friction: what is nearer to it slips. */
const SLIPS = 1 - 1e-6;
const ROOM = 0.5;  // rad or m, of a tendon that couples

export interface ConstraintRows {
  readonly count: number;
  KBIP: Float64Array;
  R: Float64Array;
  /** An edge of a pyramid of friction. */
  isEdge(row: number): boolean;
  /** True if a row is a spring now: it pushes, and does not slip. Its force says so, because MuJoCo
   * 3 leaves efc_state as it was where it solves islands. */
  isSpring(row: number): boolean;
  /** True if a row connects DoFs now: an equality, or a tendon or joint that is at its limit.
   * `ever`: an equality, or a tendon that leaves little room, whether it is at its limit or
   * not. */
  couples(row: number, ever: boolean): boolean;
  /** The contact that a row is of; undefined: another constraint's. */
  contactOf(row: number): EngineContact | undefined;
  /** Calls each(dof, value) for each entry of a row of J. */
  forParts(row: number, each: (dof: number, value: number) => void): void;
}

/** `contacts`: of the same step. */
export function rowsOf(engine: Engine, contacts: EngineContact[]): ConstraintRows {
  const { data, model, mj, mj: { mjtConstraint: kinds } } = engine, n = data.nefc, nv = model.nv;
  const edge = kinds.mjCNSTR_CONTACT_PYRAMIDAL.value;
  const ellipse = kinds.mjCNSTR_CONTACT_ELLIPTIC.value;
  const contact = new Set<number>([kinds.mjCNSTR_CONTACT_FRICTIONLESS.value, edge, ellipse]);
  const friction = new Set<number>([kinds.mjCNSTR_FRICTION_DOF.value,
                                    kinds.mjCNSTR_FRICTION_TENDON.value]);
  // Copies: the calls between may let the memory grow.
  const ints = (view: Int32Array) => view.slice(0, n);
  const floats = (view: Float64Array, each = 1) => view.slice(0, each * n);
  const type = ints(data.efc_type), id = ints(data.efc_id);
  const forces = floats(data.efc_force), most = floats(data.efc_frictionloss);
  const J = (data.efc_J as Float64Array).slice();
  const sparse = mj.mj_isSparse(model) !== 0;
  const begins = sparse ? ints(data.efc_J_rowadr) : undefined;
  const counts = sparse ? ints(data.efc_J_rownnz) : undefined;
  const columns = sparse ? (data.efc_J_colind as Int32Array).slice() : undefined;
  const contactOf = (row: number) => contact.has(type[row]!) ? contacts[id[row]!] : undefined;
  const forParts = (row: number, each: (dof: number, value: number) => void): void => {
    const begin = begins?.[row] ?? row * nv, count = counts?.[row] ?? nv;
    for (let k = 0; k < count; ++k) {
      const value = J[begin + k]!;
      if (value !== 0) each(columns?.[begin + k] ?? k, value);
    }
  };
  return {
    count: n, contactOf, forParts, KBIP: floats(data.efc_KBIP, 4), R: floats(data.efc_R),
    isEdge: (row) => type[row] === edge,
    isSpring: (row) => {
      const kind = type[row]!, force = forces[row]!;
      if (kind === kinds.mjCNSTR_EQUALITY.value) return true;
      if (friction.has(kind)) return Math.abs(force) < most[row]!;
      if (kind !== ellipse) return force > 0;
      const { efcAddress: first, dim, friction: holds } = contactOf(row)!, normal = forces[first]!;
      if (normal <= 0 || row === first) return normal > 0;
      const aside = Array.from(forces.subarray(first + 1, first + dim),
                               (along, i) => along / (holds[i]! * normal));
      return Math.hypot(...aside) < SLIPS;
    },
    couples: (row, ever) => {
      const kind = type[row]!;
      if (kind === kinds.mjCNSTR_EQUALITY.value) return true;
      const tendon = kind === kinds.mjCNSTR_LIMIT_TENDON.value;
      if (!ever) return (tendon || kind === kinds.mjCNSTR_LIMIT_JOINT.value) && forces[row]! > 0;
      if (!tendon) return false;
      let most = 0;
      forParts(row, (_, value) => { most = Math.max(most, Math.abs(value)); });
      const [low, high] = model.tendon_range.slice(2 * id[row]!, 2 * id[row]! + 2);
      return high - low <= ROOM * most;
    },
  };
}
