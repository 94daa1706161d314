/** MuJoCo's rows of constraints, as the last mj_forward or mj_step found them. */
import type { Engine, EngineContact } from "./engine.js";

export interface ConstraintRows {
  type: Int32Array;
  state: Int32Array;
  KBIP: Float64Array;
  R: Float64Array;
  /** The contact that a row is of; undefined: another constraint's. */
  contactOf(row: number): EngineContact | undefined;
  /** Calls each(dof, value) for each entry of a row of J. */
  forParts(row: number, each: (dof: number, value: number) => void): void;
}

/** Values of MuJoCo's enumerations. */
export function kindsOf({ mj: { mjtConstraint, mjtConstraintState } }: Engine) {
  return {
    frictionless: mjtConstraint.mjCNSTR_CONTACT_FRICTIONLESS.value,
    pyramid: mjtConstraint.mjCNSTR_CONTACT_PYRAMIDAL.value,
    ellipse: mjtConstraint.mjCNSTR_CONTACT_ELLIPTIC.value,
    quadratic: mjtConstraintState.mjCNSTRSTATE_QUADRATIC.value,
    cone: mjtConstraintState.mjCNSTRSTATE_CONE.value,
  };
}

/** `contacts`: of the same step. */
export function rowsOf(engine: Engine, contacts: EngineContact[]): ConstraintRows {
  const { data, model, mj } = engine, { frictionless, pyramid, ellipse } = kindsOf(engine);
  const n = data.nefc, nv = model.nv, contact = new Set<number>([frictionless, pyramid, ellipse]);
  // Copies: the calls between may let the memory grow.
  const ints = (view: Int32Array) => view.slice(0, n);
  const type = ints(data.efc_type), id = ints(data.efc_id);
  const J = (data.efc_J as Float64Array).slice();
  const sparse = mj.mj_isSparse(model) !== 0;
  const begins = sparse ? ints(data.efc_J_rowadr) : undefined;
  const counts = sparse ? ints(data.efc_J_rownnz) : undefined;
  const columns = sparse ? (data.efc_J_colind as Int32Array).slice() : undefined;
  return {
    type, state: ints(data.efc_state),
    KBIP: (data.efc_KBIP as Float64Array).slice(0, 4 * n),
    R: (data.efc_R as Float64Array).slice(0, n),
    contactOf: (row) => contact.has(type[row]!)
      ? contacts[id[row]!] : undefined,
    forParts: (row, each) => {
      const begin = begins?.[row] ?? row * nv, count = counts?.[row] ?? nv;
      for (let k = 0; k < count; ++k) {
        const value = J[begin + k]!;
        if (value !== 0) each(columns?.[begin + k] ?? k, value);
      }
    },
  };
}
