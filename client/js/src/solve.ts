/** The proxy of a simulation that has contacts and no solver of its own. */
import { contactAt, type Contact } from "./contact.js";
import { Proxy, type Plane } from "./proxy.js";
import { Skyline } from "./skyline.js";
import { along } from "./vectors.js";

export interface SolveOptions {
  /** Where to begin: the last proxy, so that the tool stays on the side of each object that it came
   * from; absent: the probe. The nearest minimum is found, not the least one: let a probe that
   * jumped come in pieces of a few mm or 0.05 rad. */
  start?: number[];
  /** Diagonal of W, per coordinate, > 0; absent: all 1. */
  weights?: number[];
  /** Most steps of Newton; absent: 50. */
  iterations?: number;
  /** Accuracy of each coordinate, in its unit; absent: 1e-10. */
  tolerance?: number;
}

export interface Solution {
  /** The proxy. */
  x: number[];
  /** contactAt() of all contacts at x. */
  planes: Plane[];
  /** false: x is the best that was found. Either the iterations did not suffice, or the rigid
   * contacts contradict each other. */
  converged: boolean;
  iterations: number;
  /** For publish(). */
  proxy: Proxy;
}

type Vector = number[];
type Matrix = Vector[];

const HALVINGS = 30;
// Least compliance of a contact, relative to what the coupling gives way.
const RIGID = 1e-12;
const NOISE = 1e-14;  // of the energy: what rounding may raise it by

const plus = (a: Vector, factor: number, b: Vector): Vector =>
  a.map((value, i) => value + factor * b[i]!);

/** A symmetric A by its factor; undefined: A is not positive definite. */
function factor(A: Matrix): Skyline | undefined {
  const L = new Skyline();
  L.begin(A.length);
  A.forEach((_, i) => L.reach(i, 0));
  A.forEach((row, i) => row.slice(0, i + 1).forEach((value, k) => L.add(i, k, value)));
  return L.factor(0, 1e-14) ? L : undefined;
}

/** A^-1 b, by the factor L of A. */
function solved(L: Skyline, b: Vector): Vector {
  const x = Float64Array.from(b);
  L.solve(x);
  return [...x];
}

/** The m >= 0 that minimises m^T A m / 2 + b^T m, A positive definite (Lawson and Hanson, Solving
 * Least Squares Problems, ch. 23). */
function pushes(A: Matrix, b: Vector): Vector {
  const m = b.map(() => 0), least = 1e-14 * Math.max(0, ...b.map(Math.abs));
  let pushing: number[] = [];
  for (let turn = 0; turn < 3 * b.length; ++turn) {
    const depths = b.map((gap, i) => (pushing.includes(i) ? 0 : -gap - along(A[i]!, m)));
    const deepest = depths.indexOf(Math.max(...depths));
    if (!(depths[deepest]! > least)) break;
    pushing.push(deepest);
    for (let done = false; !done;) {
      const L = factor(pushing.map((i) => pushing.map((j) => A[i]![j]!)));
      if (L === undefined) return m;
      const wanted = solved(L, pushing.map((i) => -b[i]!));
      let share = 1, lettingGo = -1;  // of the way to what is wanted, until one of them lets go
      for (const [k, i] of pushing.entries()) {
        if (wanted[k]! > 0 || m[i]! > share * (m[i]! - wanted[k]!)) continue;
        share = m[i]! / (m[i]! - wanted[k]!);
        lettingGo = i;
      }
      for (const [k, i] of pushing.entries()) m[i]! += share * (wanted[k]! - m[i]!);
      done = lettingGo < 0;
      if (!done) m[lettingGo] = 0;
      pushing = pushing.filter((i) => i !== lettingGo);
    }
  }
  return m;
}

function check(name: string, values: readonly number[], size: number, positive = false): void {
  if (values.length !== size) {
    throw new RangeError(`${name}: has ${values.length} values, must have ${size}`);
  }
  for (const [i, value] of values.entries()) {
    if (Number.isFinite(value) && !(positive && value <= 0)) continue;
    throw new RangeError(`${name}[${i}]: ${value}, must be finite${positive ? " and > 0" : ""}`);
  }
}

/** The contacts at one x. */
interface Place {
  x: Vector;
  gaps: Vector;
  gradients: Matrix;
  planes: Required<Plane>[];
}

function placeAt(contacts: (x: number[]) => Contact[], x: Vector, coupling: number): Place {
  const told = contacts(x);
  const planes = told.map((contact, i) => {
    const name = `contacts[${i}]`, stiffness = contact.stiffness ?? Infinity;
    if (!Number.isFinite(contact.gap)) {
      throw new RangeError(`${name}.gap: ${contact.gap}, must be finite`);
    }
    if (!(stiffness > 0)) throw new RangeError(`${name}.stiffness: ${stiffness}, must be > 0`);
    const plane = contactAt(x, contact, coupling) as Required<Plane>;
    check(`${name}.normal . point.jacobian`, plane.normal, x.length);
    check(`${name}.curvature`, plane.curvature, plane.curvature.length);
    return plane;
  });
  return { x, planes, gaps: told.map(({ gap }) => gap),
    gradients: planes.map(({ normal }) => normal.map((value) => -value)) };
}

/** Energy of coupling and contacts, over the coupling; a rigid one costs `rigid` by its depth. */
function energyOf(at: Place, probe: Vector, weights: Vector, rigid: number): number {
  const pulled = at.x.reduce((sum, v, i) => sum + weights[i]! * (v - probe[i]!) ** 2 / 2, 0);
  return at.planes.reduce((sum, { compliance }, i) => {
    const depth = Math.max(-at.gaps[i]!, 0);
    return sum + (compliance > 0 ? depth * depth / compliance / 2 : rigid * depth);
  }, pulled);
}

interface Step {
  way: Vector;
  pushes: Vector;
}

/** To the minimum of the model whose second derivative has the factor L. */
function stepBy(at: Place, pull: Vector, L: Skyline): Step {
  const free = solved(L, pull);
  const moves = at.gradients.map((gradient) => solved(L, gradient));
  const A = at.gradients.map((gradient) => moves.map((move) => along(gradient, move)));
  for (const [i, row] of A.entries()) {
    row[i] = row[i]! + Math.max(at.planes[i]!.compliance, RIGID * row[i]!) || 1;
  }
  const forces = pushes(A, at.gaps.map((gap, i) => gap + along(at.gradients[i]!, free)));
  return { pushes: forces, way: moves.reduce((way, move, i) => plus(way, forces[i]!, move), free) };
}

/** First with flat gaps, then with the curvature that their pushes give the energy, unless that
 * model has no minimum. */
function stepFrom(at: Place, probe: Vector, weights: Vector): Step {
  const H = weights.map((weight, i) => weights.map((_, j) => (i === j ? weight : 0)));
  const pull = at.x.map((value, i) => weights[i]! * (probe[i]! - value));
  const flat = stepBy(at, pull, factor(H)!);
  for (const [p, { curvature, firstCoordinate: first }] of at.planes.entries()) {
    for (let k = 0, i = first; k < curvature.length; ++i) {
      for (let j = first; j <= i; ++j) H[i]![j]! -= flat.pushes[p]! * curvature[k++]!;
    }
  }
  const L = factor(H);
  return L === undefined ? flat : stepBy(at, pull, L);
}

/** The x that minimises, near options.start,
 *   coupling / 2 (x - xProbe)^T W (x - xProbe) + sum_i stiffness_i / 2 min(gap_i(x), 0)^2,
 * with gap_i >= 0 where there is no stiffness. `contacts` gives those of the tool at x, touched or
 * near; from one x to the next one may come or go where its gap is > 0. `coupling`: N/m if x is in
 * m, N m/rad if in rad, > 0. x - xProbe is a plain difference of numbers: let an angle of xProbe be
 * the one nearest to the start, and a quaternion have the sign that is nearer. The method and more
 * is in C++'s solve.hpp. Throws RangeError if a number is not finite or not allowed. */
export function solve(contacts: (x: number[]) => Contact[], xProbe: number[], coupling: number,
                      options: SolveOptions = {}): Solution {
  const n = xProbe.length, weights = options.weights ?? xProbe.map(() => 1);
  const tolerance = options.tolerance ?? 1e-10, most = options.iterations ?? 50;
  check("xProbe", xProbe, n);
  check("options.start", options.start ?? xProbe, n);
  check("options.weights", weights, n, true);
  check("coupling", [coupling], 1, true);
  let here = placeAt(contacts, [...(options.start ?? xProbe)], coupling);
  let still = false, iterations = 0;
  const found = (converged: boolean): Solution => {
    const { x, planes } = here;
    return { x, planes, converged, iterations,
      proxy: planes.length > 0 ? Proxy.behind(planes, x) : Proxy.free() };
  };
  while (!still && iterations < most) {
    ++iterations;
    const step = stepFrom(here, xProbe, weights);
    const rigid = 1.5 * Math.max(0, ...step.pushes);  // > the pushes: no violation pays
    const energy = energyOf(here, xProbe, weights, rigid);
    let share = 1, there = here;
    for (let halving = 0; halving <= HALVINGS + 1; ++halving, share /= 2) {
      if (halving > HALVINGS) return found(false);
      there = placeAt(contacts, plus(here.x, share, step.way), coupling);
      if (energyOf(there, xProbe, weights, rigid) <= energy + NOISE * Math.abs(energy)) break;
    }
    here = there;
    still = share * Math.max(0, ...step.way.map(Math.abs)) <= tolerance;
  }
  const inside = here.planes.some(({ compliance, normal }, i) =>
    compliance === 0 && here.gaps[i]! < -10 * tolerance * Math.hypot(...normal));
  return found(still && !inside);
}
