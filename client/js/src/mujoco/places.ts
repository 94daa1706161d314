/** The bindings of a tool, found in its model. */
import type { Vector3 } from "../vectors.js";
import { countOf } from "./binding.js";
import type { Binding } from "./binding.js";
import type { Engine } from "./engine.js";
import { product, quaternionAt, vectorAt } from "./vectors.js";
import type { Quaternion } from "./vectors.js";

const MOST_COORDINATES = 10000;  // far above those of any device

/** One binding, found. */
export interface Place {
  binding: Binding;
  /** Number of the joint, site or body. */
  id: number;
  /** That it moves. */
  body: number;
  site: boolean;
  /** A hinge's angle. */
  turns: boolean;
  /** That it moves itself, without those of its parents. */
  dofs: number[];
  /** That its spring meets at least, kg, or kg m^2 of a hinge. */
  mass: number;
  /** Least inertia of a pose, kg m^2. */
  inertia: number;
  /** b less a of a joint's coordinate; of an angle the short way round. */
  apart(a: number, b: number): number;
}

export function refuse(binding: Binding, why: string): never {
  throw new RangeError(`binding '${binding.name}': ${why}`);
}

/** Position of a site or body, in the world. */
export const positionOf = (engine: Engine, { site, id }: Place): Vector3 =>
  vectorAt(engine.view(site ? "site_xpos" : "xpos"), 3 * id);

/** Turn of a site or body, from its frame to the world. */
export function turnOf(engine: Engine, { site, id, body }: Place): Quaternion {
  const ofBody = quaternionAt(engine.view("xquat"), 4 * body);
  return site ? product(ofBody, quaternionAt(engine.fixed.siteQuat, 4 * id)) : ofBody;
}

/** Inverse masses of the lightest direction of a site or body, 1/kg, and about its lightest axis,
 * 1/(kg m^2): no less than the largest eigenvalues of J M^-1 J^T. */
function inverseMasses(engine: Engine, place: Place): [number, number] {
  const nv = engine.model.nv;
  const { linear, angular } = engine.jacobian(place.body, positionOf(engine, place));
  const J = Float64Array.from([...linear, ...angular]), solved = engine.overMass(J);
  const most: [number, number] = [0, 0];
  for (let i = 0; i < 6; ++i) {
    const half = i < 3 ? 0 : 1;
    let sum = 0;
    for (let k = 3 * half; k < 3 * half + 3; ++k) {
      let product = 0;
      for (let j = 0; j < nv; ++j) product += J[i * nv + j]! * solved[k * nv + j]!;
      sum += Math.abs(product);
    }
    most[half] = Math.max(most[half], sum);
  }
  return most;
}

/** After mj_forward. Throws RangeError. */
export function findPlace(engine: Engine, binding: Binding): Place {
  const { kind, name, firstCoordinate, scale } = binding, { mj, fixed } = engine;
  if (!(firstCoordinate >= 0 && firstCoordinate <= MOST_COORDINATES - countOf(kind))) {
    refuse(binding, `coordinate ${firstCoordinate}: a device has at most ${MOST_COORDINATES}`);
  }
  const place: Place = { binding, id: -1, body: 0, site: false, turns: false, dofs: [], mass: 0,
    inertia: 0, apart: (a, b) => {
      const way = b - a, round = 2 * Math.PI;
      return place.turns && Math.abs(way) > Math.PI ? way - round * Math.round(way / round) : way;
    } };
  if (kind === "joint") {
    place.id = engine.idOf("JOINT", name);
    if (place.id < 0) refuse(binding, "the model has no joint of this name");
    place.turns = fixed.jointType[place.id] === mj.mjtJoint.mjJNT_HINGE.value;
    if (!place.turns && fixed.jointType[place.id] !== mj.mjtJoint.mjJNT_SLIDE.value) {
      refuse(binding,
             "must be a hinge or a slide; bind the body of a free or ball joint by pose()");
    }
    if (scale === 0 || !Number.isFinite(scale)) {
      refuse(binding, "scale must not be 0, and finite");
    }
    const dof = fixed.jointDof[place.id]!;
    place.body = fixed.jointBody[place.id]!;
    place.dofs = [dof];
    place.mass = scale * scale / fixed.dofInvweight[dof]!;
  } else {
    place.id = engine.idOf("SITE", name);
    place.site = place.id >= 0;
    if (!place.site) place.id = engine.idOf("BODY", name);
    if (place.id < 0) refuse(binding, "the model has no site and no body of this name");
    place.body = place.site ? fixed.siteBody[place.id]! : place.id;
    for (let k = 0; k < fixed.bodyDofs[place.body]!; ++k) {
      place.dofs.push(fixed.bodyDof[place.body]! + k);
    }
    const [linear, angular] = inverseMasses(engine, place);
    if (!(linear > 0)) refuse(binding, "its body cannot move: it has no joint");
    place.mass = 1 / linear;
    place.inertia = 1 / Math.max(angular, mj.mjMINVAL);
  }
  return place;
}

/** Refuses coordinate i if it is too stiff; `whole`: c w. */
export function refuseStiff(engine: Engine, place: Place, i: number, whole: number): void {
  const turn = place.binding.kind === "pose" && i >= place.binding.firstCoordinate + 3;
  const stiffness = whole * (turn ? 0.25 : 1), mass = turn ? place.inertia : place.mass;
  const step = engine.opt.timestep;
  if (step * Math.sqrt(stiffness / mass) <= 0.5) return;
  refuse(place.binding, `the coupling is too stiff for the model's step: coordinate ${i} has a ` +
    `mass of ${mass.toPrecision(3)} kg (kg m^2) and needs at least ` +
    `${(4 * step * step * stiffness).toPrecision(3)}; give it mass or armature, shorten the ` +
    `timestep, or lower the coupling or its weight`);
}
