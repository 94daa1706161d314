// Two devices made by hand: a finger whose carriage slides and whose links turn, and a hand of five
// such fingers.

import type { Device, DeviceState, Drawing, DrawnBody } from "hapticd";

/** Some of a message's fields. */
type Some<T> = T extends readonly (infer Item)[] ? Some<Item>[]
  : T extends object ? { [Name in keyof T]?: Some<T[Name]> } : T;
/** A message of which the page reads these fields. */
export const message = <T>(fields: Some<T>): T => fields as T;

const FINGERS = ["thumb", "index", "middle", "ring", "little"];
const RADIUS = 0.008;

const motion = (kind: number, axis: number[], value: number, index: number) => ({
  kind, axis, value, index, factor: 1, offset: 0, target: 0, targetPoint: [],
});
const body = (name: string, part: number, parent: number, position: number[],
              more: Some<DrawnBody>) => message<DrawnBody>(
  { name, part, parent, position, orientation: [], motions: [], capsules: [], ...more });

/** Bodies of finger `n` that stands at `z`, after `first` others. */
function finger(n: number, z: number, first: number): DrawnBody[] {
  const capsule = (to: number[], radius: number) => ({ from: [], to, radius });
  const along = [0.045, 0, 0];
  return [
    body(`${FINGERS[n]} rail`, 1, -1, [-0.05, 0.035, z],
         { capsules: [capsule([0.05, 0, 0], 0.002)] }),
    body(`${FINGERS[n]} carriage`, 1, first, [],
         { motions: [motion(2, [1, 0, 0], 1, 2 * n)], capsules: [capsule([], 0.006)] }),
    body(`${FINGERS[n]} link`, 1, first + 1, [], {
      motions: [motion(1, [0, 0, 1], 1, 2 * n + 1)],
      capsules: [
        capsule([0.04, 0, 0], 0.003),
        { from: [0.04, 0, 0], to: [0.06, -0.015, 0], radius: 0.003 },
      ],
    }),
    body(`${FINGERS[n]} proximal`, 2, -1, [0, 0, z],
         { motions: [motion(1, [0, 0, -1], 2, 2 * n)], capsules: [capsule(along, RADIUS)] }),
    body(`${FINGERS[n]} middle`, 2, first + 3, along, {
      motions: [motion(1, [0, 0, -1], 2, 2 * n + 1)],
      capsules: [capsule([0.03, 0, 0], RADIUS)],
    }),
  ];
}

function drawing(count: number): Drawing {
  const bodies: DrawnBody[] = [];
  for (let n = 0; n < count; n++) bodies.push(...finger(n, -0.022 * n, bodies.length));
  const forces = Array.from({ length: count }, (_, n) => ({
    actuator: n, body: 5 * n + 1, point: [], axis: [1, 0, 0], torque: false,
  }));
  return message<Drawing>({ bodies, forces });
}

function device(name: string, count: number): Device {
  const prefix = (n: number) => (count > 1 ? `${FINGERS[n]}.` : "");
  const each = <T>(make: (n: number) => T) => Array.from({ length: count }, (_, n) => make(n));
  return message<Device>({
    name,
    kind: "simulated",
    model: "finger exoskeleton",
    moves: true,
    dofs: each((n) => [
      { name: `${prefix(n)}l_x`, unit: "m", actuated: true, lower: 0, upper: 0.05, maxEffort: 40 },
      { name: `${prefix(n)}q_B`, unit: "rad", actuated: false, lower: -1, upper: 1, maxEffort: 0 },
    ]).flat(),
    coordinates: [],
    forceLimit: each(() => 25),
    stiffnessLimit: each(() => 1500),
    controller: "soft-grasp",
    tracker: "",
    wantsTracker: false,
    calibrated: "",
    unguarded: [],
    drawing: drawing(count),
  });
}

export function madeDevices(): Device[] {
  return [device("finger", 1), device("hand", 5)];
}

/** `t` in s. */
export function madeState(name: string, t: number, faults: number): DeviceState {
  const count = name === "hand" ? 5 : 1;
  const each = (make: (n: number) => number[]) =>
    Array.from({ length: count }, (_, n) => make(n)).flat();
  const phase = (n: number) => Math.sin(1.3 * t + 0.5 * n);
  const touch = faults === 0 && phase(0) > 0.1;
  const push = (n: number) => (faults === 0 ? Math.max(phase(n) - 0.1, 0) : 0);
  return message<DeviceState>({
    seq: BigInt(Math.round(t * 1000)),
    serverTimeNs: BigInt(Math.round((1000 + t) * 1e9)),
    state: faults === 0 ? 5 : 7,
    mode: 3,
    proxySeqUsed: 17n,
    proxyAgeUs: BigInt(Math.round(8000 + 5000 * ((t * 30) % 1))),
    staleness: 1,
    gain: faults === 0 ? 1 : 0,
    transport: 2,
    q: each((n) => [0.02 + 0.012 * phase(n), -0.3 + 0.25 * phase(n)]),
    xProbe: each((n) => [0.5 + 0.4 * phase(n), 0.4 + 0.3 * phase(n)]),
    x: each((n) => [0.5 + 0.4 * Math.min(phase(n), 0.1), 0.4 + 0.3 * Math.min(phase(n), 0.1)]),
    qStar: each((n) => [0.02 + 0.012 * Math.min(phase(n), 0.1), -0.3 + 0.25 * phase(n)]),
    tauA: each((n) => [-18 * push(n) - 0.4 * Math.cos(1.3 * t)]),
    tauElastic: each((n) => [-18 * push(n)]),
    errorBound: each((n) => [0.05 + 0.4 * push(n)]),
    stiffnessInEffect: each(() => [820]),
    derating: 2,
    deratingDelayUs: 50000n,
    activePlanes: touch ? 0b101 : 0,
    faults,
    limiters: touch && phase(0) > 0.9 ? 2 : 0,
    passivity: { tank: 0.003 - 0.001 * push(0) },
  });
}
