// The state of a device in words.

import { Lifecycle, Mode, type Device, type DeviceState } from "../model";
import { actuated, effortUnit, number, shownIn } from "../units";

/** How it is told apart besides the words: a colour and a sign of its own. */
export type Tone = "calm" | "ready" | "force" | "fault";

export interface StateWords {
  name: string; // the protocol's: "ENGAGED"
  title: string;
  help: string;
  tone: Tone;
}

const STATES: Record<number, StateWords> = {
  [Lifecycle.INIT]: {
    name: "INIT",
    title: "Starting",
    help: "No position of the device has come yet.",
    tone: "calm",
  },
  [Lifecycle.IDLE]: {
    name: "IDLE",
    title: "Waiting",
    help: "No force. No program controls the device.",
    tone: "calm",
  },
  [Lifecycle.ARMED]: {
    name: "ARMED",
    title: "Ready",
    help: "No force. A program controls the device and may switch force on.",
    tone: "ready",
  },
  [Lifecycle.ENGAGING]: {
    name: "ENGAGING",
    title: "Force is fading in",
    help: "A program switched force on.",
    tone: "force",
  },
  [Lifecycle.ENGAGED]: {
    name: "ENGAGED",
    title: "Force is on",
    help: "A spring pulls the device to where the simulation lets it be.",
    tone: "force",
  },
  [Lifecycle.RELEASING]: {
    name: "RELEASING",
    title: "Force is fading out",
    help: "Force was released.",
    tone: "force",
  },
  [Lifecycle.FAULT]: {
    name: "FAULT",
    title: "Stopped by a fault",
    help: "No force until the fault is cleared.",
    tone: "fault",
  },
  [Lifecycle.CLOSING]: {
    name: "CLOSING",
    title: "Shutting down",
    help: "The server ends.",
    tone: "calm",
  },
};

export function stateWords(state: number): StateWords {
  return STATES[state] ?? { name: `${state}`, title: "Unknown", help: "", tone: "calm" };
}

/** "Force is on" of "ENGAGING -> ENGAGED"; empty: no such state. */
export function changeWords(reason: string): string {
  const name = reason.split(" -> ")[1];
  return Object.values(STATES).find((words) => words.name === name)?.title ?? "";
}

const STALENESS = ["", "fresh", "late: the last one is held", "too old: force fades", "lost"];

/** The simulation's proxy as the server knows it. */
export function proxyWords(state: DeviceState): string {
  if (state.proxySeqUsed === 0n) return "No proxy: no simulation sends one.";
  const age = number(Number(state.proxyAgeUs) * 1e-3, 1);
  return `Proxy is ${STALENESS[state.staleness] ?? ""}, ${age} ms old.`;
}

/** Things that the tool touches. */
export function contactWords(state: DeviceState): string {
  if (state.proxySeqUsed === 0n) return "Nothing: no simulation is connected.";
  switch (state.mode) {
    case Mode.FREE:
      return "Nothing is in the way.";
    case Mode.HELD:
      return "Held where the simulation keeps the tool, free where it does not.";
    case Mode.PLANES:
      return planesWords(state.activePlanes >>> 0);
    default:
      return "Nothing.";
  }
}

function planesWords(bits: number): string {
  const planes: number[] = [];
  for (let plane = 0; plane < 32; plane++) if ((bits >>> plane) & 1) planes.push(plane);
  if (planes.length === 0) return "Not touching: no surface is reached.";
  if (planes.length === 1) return `Touching surface ${planes[0]} of the simulation.`;
  const last = planes.pop();
  return (
    `Touching ${planes.length + 1} surfaces of the simulation: ` +
    `${planes.join(", ")} and ${last}.`
  );
}

const DELAYS = ["", "samples of the device are", "the held proxy is", "planes that change are"];

/** "slide 1500 → 820 N/m: the held proxy is 50 ms old", of the actuator derated most; empty: no
 * force, or none is derated. */
export function deratingWords(device: Device, state: DeviceState): string {
  const why = DELAYS[state.derating];
  if (!why || !(state.gain > 0)) return "";
  let words = "";
  let least = 1;
  actuated(device).forEach((dof, i) => {
    const whole = device.stiffnessLimit[i] ?? NaN;
    const share = (state.stiffnessInEffect[i] ?? NaN) / state.gain / whole;
    if (!(share < least)) return;
    least = share;
    const unit = `${shownIn(effortUnit(dof.unit)).unit}/${dof.unit}`;
    const delay = number(Number(state.deratingDelayUs) * 1e-3, 0);
    words =
      `${dof.name} ${whole.toPrecision(4)} → ${(share * whole).toPrecision(4)} ${unit}: ` +
      `${why} ${delay} ms old`;
  });
  return words;
}
