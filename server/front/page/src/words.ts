// The state of a device in words.

import {
  bitNames, DeviceStateNameSchema, effortUnit, enumName, ProxyMode, type Device, type DeviceState,
} from "hapticd";
import { actuated, number, shownIn } from "./units";

/** How it is told apart besides the words: a colour and a sign of its own. */
export type Tone = "calm" | "ready" | "force" | "fault";

/** Words of each state, under the protocol's name. */
const STATES: Record<string, [title: string, tone: Tone, help: string]> = {
  INIT: ["Starting", "calm", "No position of the device has come yet."],
  IDLE: ["Waiting", "calm", "No force. No program controls the device."],
  ARMED: ["Ready", "ready", "No force. A program controls the device and may switch force on."],
  ENGAGING: ["Force is fading in", "force", "A program switched force on."],
  ENGAGED: [
    "Force is on",
    "force",
    "A spring pulls the device to where the simulation lets it be.",
  ],
  RELEASING: ["Force is fading out", "force", "Force was released."],
  FAULT: ["Stopped by a fault", "fault", "No force until the fault is cleared."],
  CLOSING: ["Shutting down", "calm", "The server ends."],
};

export function stateWords(state: number) {
  const name = enumName(DeviceStateNameSchema, state);
  const [title, tone, help] = STATES[name] ?? ["Unknown", "calm", ""];
  return { name, title, tone, help };
}

/** "Force is on" of "ENGAGING -> ENGAGED"; empty: no such state. */
export function changeWords(reason: string): string {
  return STATES[reason.split(" -> ")[1] ?? ""]?.[0] ?? "";
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
    case ProxyMode.FREE:
      return "Nothing is in the way.";
    case ProxyMode.HELD:
      return "Held where the simulation keeps the tool, free where it does not.";
    case ProxyMode.PLANES:
      return planesWords(bitNames("activePlanes", state.activePlanes));
    default:
      return "Nothing.";
  }
}

function planesWords(planes: string[]): string {
  if (planes.length === 0) return "Not touching: no surface is reached.";
  if (planes.length === 1) return `Touching surface ${planes[0]} of the simulation.`;
  const first = planes.slice(0, -1).join(", ");
  return `Touching ${planes.length} surfaces of the simulation: ${first} and ${planes.at(-1)}.`;
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
