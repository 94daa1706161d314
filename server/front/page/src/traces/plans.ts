// Which traces a device has, and where their values come from.

import {
  effortUnit, type DegreeOfFreedom, type Device, type DeviceState, type GetServerInfoResponse,
} from "hapticd";
import { actuated, shownIn } from "../units";

export interface Line {
  label: string;
  unit: string; // as shown: "mm"
  digits: number;
  colour: number; // of the palette, --line-0 ...
  dashed?: boolean;
}

export interface Plan {
  id: string;
  title: string;
  help: string;
  lines: Line[];
  /** Said in place of a trace that never had a value. */
  absent: string;
}

export interface StatePlan extends Plan {
  /** One value per line in the line's unit; NaN or missing: none. */
  sample(state: DeviceState): number[];
}

export const PALETTE = 8;

/** A line per DoF, and values in SI as these lines show them. */
function perDof(dofs: DegreeOfFreedom[], unit: (dof: DegreeOfFreedom) => string, suffix = "",
                dashed = false) {
  const shown = dofs.map((dof) => shownIn(unit(dof)));
  const lines = dofs.map(({ name }, i): Line => ({
    label: name + suffix,
    unit: shown[i]!.unit,
    digits: shown[i]!.digits,
    colour: i,
    dashed: dashed || i >= PALETTE,
  }));
  const scaled = (values: readonly number[]) =>
    shown.map(({ factor }, i) => (values[i] ?? NaN) * factor);
  return { lines, scaled };
}
const effort = ({ unit }: DegreeOfFreedom): string => effortUnit(unit);

function forces(device: Device): StatePlan {
  const total = perDof(actuated(device), effort, " total");
  const spring = perDof(actuated(device), effort, " spring", true);
  return {
    id: "force",
    title: "Force",
    help: "Solid: what the actuators are told to give. Dashed: the spring's part of it.",
    lines: [...total.lines, ...spring.lines],
    absent: "This device has no actuator.",
    sample: (state) => [...total.scaled(state.tauA), ...spring.scaled(state.tauElastic)],
  };
}

function positions(device: Device): StatePlan {
  const { lines, scaled } = perDof(device.dofs, ({ unit }) => unit);
  return {
    id: "position",
    title: "Position",
    help: "Where each joint of the device stands.",
    lines,
    absent: "No position came yet.",
    sample: (state) => scaled(state.q),
  };
}

function age(): StatePlan {
  return {
    id: "age",
    title: "Age of the proxy",
    help: "How long ago the simulation last said where the tool may be.",
    lines: [{ label: "age", unit: "ms", digits: 1, colour: 0 }],
    absent: "No simulation sends a proxy.",
    sample: (state) => [state.proxySeqUsed === 0n ? NaN : Number(state.proxyAgeUs) * 1e-3],
  };
}

function bound(device: Device): StatePlan {
  const { lines, scaled } = perDof(actuated(device), effort);
  return {
    id: "bound",
    title: "Error bound of the force",
    help: "How far the force is, at most, from what the simulation would make felt now.",
    lines,
    absent: "Not known: the simulation does not say how sure it is of its contacts.",
    sample: (state) => scaled(state.errorBound),
  };
}

function tank(): StatePlan {
  return {
    id: "tank",
    title: "Energy tank",
    help: "What changes of the spring may still give out. Empty: force is held back.",
    lines: [{ label: "level", unit: "mJ", digits: 2, colour: 2 }],
    absent: "The scene has no energy tank.",
    sample: (state) => [state.passivity ? state.passivity.tank * 1e3 : NaN],
  };
}

/** The traces of the device's states. */
export function plans(device: Device): StatePlan[] {
  return [forces(device), positions(device), age(), bound(device), tank()];
}

/** Asked of the server once per second. */
export const LATENESS: Plan = {
  id: "lateness",
  title: "Lateness of the loop",
  help: "How late the control loop woke up in the last 10 s: half of all times, 99 %, the worst.",
  lines: [
    { label: "half", unit: "µs", digits: 0, colour: 0 },
    { label: "99 %", unit: "µs", digits: 0, colour: 1 },
    { label: "worst", unit: "µs", digits: 0, colour: 3, dashed: true },
  ],
  absent: "No figure came yet.",
};

export function lateness({ loop }: GetServerInfoResponse): number[] {
  return loop ? [loop.latenessP50Us, loop.latenessP99Us, loop.latenessMaxUs] : [];
}
