// Numbers as people read them: mm, degrees, N, ms. Inside everything is SI.

import type { Device, SessionLink } from "hapticd";

/** Unit in which a quantity is shown, and its size in SI. */
export interface Shown {
  unit: string;
  factor: number;
  digits: number;
}

const SHOWN: Record<string, Shown> = {
  m: { unit: "mm", factor: 1e3, digits: 1 },
  rad: { unit: "°", factor: 180 / Math.PI, digits: 1 },
  N: { unit: "N", factor: 1, digits: 2 },
  "N m": { unit: "N·m", factor: 1, digits: 3 },
};

export function shownIn(unit: string): Shown {
  return SHOWN[unit] ?? { unit, factor: 1, digits: 3 };
}

/** The actuated DoFs in the order of tau_a. */
export function actuated(device: Device) {
  return device.dofs.filter((dof) => dof.actuated);
}

/** Typographic minus; "–" if there is no number. */
export function number(value: number | undefined, digits: number): string {
  if (value === undefined || !Number.isFinite(value)) return "–";
  const text = value.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text.replace("-", "−");
}

/** "12.5 mm", "30.0°". */
export function withUnit(text: string, unit: string): string {
  return text === "–" ? text : unit === "°" ? `${text}°` : `${text} ${unit}`;
}

/** "12.5 mm" of 0.0125 m. */
export function quantity(value: number | undefined, unit: string): string {
  const shown = shownIn(unit);
  const text = number(value === undefined ? undefined : value * shown.factor, shown.digits);
  return withUnit(text, shown.unit);
}

export function milliseconds(duration: SessionLink["ageP50"]): number | undefined {
  return duration && Number(duration.seconds) * 1e3 + duration.nanos * 1e-6;
}

/** "3 d 4 h", "2 h 5 min", "12 s". */
export function howLong(seconds: number): string {
  const at = (size: number) => Math.floor(seconds / size);
  const parts = [`${at(86400)} d`, `${at(3600) % 24} h`, `${at(60) % 60} min`, `${at(1) % 60} s`];
  const first = parts.findIndex((part) => !part.startsWith("0 "));
  return parts.slice(first, first + 2).filter((part) => !part.startsWith("0 ")).join(" ") || "0 s";
}
