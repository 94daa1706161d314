/** The spring that a MuJoCo contact is when it is held still.
 *
 * MuJoCo gives each contact the reference acceleration a_ref = -B v - K d(r) r, with r the
 * penetration (negative), and exerts f = (a_ref - a) / R, R = (1 - d) / d A, A its estimate of
 * J M^-1 J^T: the inverse mass that meets at the contact, from body_invweight0 of both bodies. At
 * rest (v = a = 0) that is a spring,
 *
 *   f = K d(r)^2 / ((1 - d(r)) A) |r|,
 *
 * with K = 1 / (dmax timeconst dampratio)^2 for a positive solref, -solref[0] / dmax^2 for a
 * negative one, and d the impedance of solimp, which rises from d0 to dmax over its width. What
 * is left out is viscous (B / R, and a mass 1 / R) and ends with the motion. With the pyramidal
 * cone 2 (dim - 1) edges share the force, each with R = 2 mu^2 R_0, R_0 from A (1 + mu_0^2). */
import type { Engine, EngineContact } from "./engine.js";

/** 1/kg: both bodies are part of the world. */
const LEAST_INVERSE_MASS = 1e-12;

const clamp = (value: number, low: number, high: number): number =>
  Math.min(Math.max(value, low), high);

export class ContactSpring {
  private readonly solimp: number[];
  /** K / A and what the cone makes of it, N/m. */
  private readonly perDepth: number;

  /** `contact`: only its parameters are used, so it need not touch. */
  constructor(engine: Engine, contact: EngineContact) {
    const { mj, opt, fixed } = engine, { solref, dim } = contact;
    const solimp = [...contact.solimp];
    for (const i of [0, 1, 3]) solimp[i] = clamp(solimp[i]!, mj.mjMINIMP, mj.mjMAXIMP);
    solimp[4] = Math.max(solimp[4]!, 1);
    this.solimp = solimp;
    const dmax = solimp[1]!;
    let K = -solref[0]! / (dmax * dmax);
    if (solref[0]! > 0) {
      const safe = (opt.disableflags & mj.mjtDisableBit.mjDSBL_REFSAFE.value) === 0;
      const time = Math.max(solref[0]!, safe ? 2 * opt.timestep : 0);
      K = 1 / (dmax * time * solref[1]!) ** 2;
    }
    let inverseMass = 0;
    for (const geom of [contact.geom1, contact.geom2]) {
      if (geom >= 0) inverseMass += fixed.bodyInvweight[2 * fixed.geomBody[geom]!]!;
    }
    let perDepth = K / Math.max(inverseMass, LEAST_INVERSE_MASS);
    if (dim > 1 && opt.cone === mj.mjtCone.mjCONE_PYRAMIDAL.value) {
      const mu = contact.friction[0]!, ratio = Math.max(opt.impratio, mj.mjMINVAL);
      perDepth *= (dim - 1) * ratio / (mu * mu * (1 + mu * mu));
    }
    this.perDepth = perDepth;
  }

  private impedance(depth: number): number {
    const [d0, dmax, width, middle, power] =
      this.solimp as [number, number, number, number, number];
    if (d0 === dmax || width <= 1e-15) return 0.5 * (d0 + dmax);
    const x = Math.min(Math.abs(depth) / width, 1);
    const y = x <= middle ? x ** power / middle ** (power - 1)
      : 1 - (1 - x) ** power / (1 - middle) ** (power - 1);
    return d0 + y * (dmax - d0);
  }

  /** Normal force, N, at a penetration of `depth` m (<= 0: none). */
  force(depth: number): number {
    if (!(depth > 0)) return 0;
    const d = this.impedance(depth);
    return this.perDepth * d * d / (1 - d) * depth;
  }
  /** df/d(depth), N/m, > 0. */
  slope(depth: number): number {
    const step = 1e-4 * Math.max(this.solimp[2]!, 1e-6), at = Math.max(depth, step);
    return Math.max((this.force(at + step) - this.force(at - step)) / (2 * step), 1e-9);
  }
  /** Stiffness to tell for a contact, N/m: inside its slope; before it touches, what force over
   * depth will be at half of solimp's width. */
  stiffness(depth: number): number {
    if (depth > 0) return this.slope(depth);
    const half = 0.5 * Math.max(this.solimp[2]!, 1e-6);
    return this.force(half) / half;
  }
}
