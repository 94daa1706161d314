// "Who is connected": the sessions of the device, and how their samples and states travel.

import { Role, type SessionLink } from "hapticd";
import { at, facts, html, render } from "../dom";
import { milliseconds, number } from "../units";

const ROLES = ["", "controls the device", "looks on", "tracks the palm"];
const CARRIERS = ["", "gRPC", "UDP", "WebSocket"];

function carriers({ samplesBy, statesBy, transports }: SessionLink): string {
  const samples = CARRIERS[samplesBy];
  const states = CARRIERS[statesBy];
  if (samples && states) {
    return samples === states ? samples : `samples by ${samples}, states by ${states}`;
  }
  const known = samples || states || transports.map((t) => CARRIERS[t.transport]).join(", ");
  return known || "no message yet";
}

function ms(value: number | undefined): string {
  return value === undefined ? "not known" : `${number(value, 1)} ms`;
}

/** Troubles of all carriers and both directions. */
function troubles(session: SessionLink): string {
  let lost = 0n;
  const rejected = new Map<string, bigint>();
  for (const { up, down } of session.transports) {
    for (const direction of [up, down]) {
      lost += direction?.lost ?? 0n;
      for (const { reason, count } of direction?.rejected ?? []) {
        rejected.set(reason, (rejected.get(reason) ?? 0n) + count);
      }
    }
  }
  const parts = [...rejected].map(([reason, count]) => `${count} not used (${reason})`);
  if (lost > 0n) parts.unshift(`${lost} lost`);
  return parts.length > 0 ? parts.join(", ") : "none lost";
}

function figures(session: SessionLink): [string, string][] {
  const roundTrip = session.transports.map((t) => milliseconds(t.roundTrip)).find(Boolean);
  const list: [string, string][] = [
    ["Carrier", carriers(session)],
    ["Messages", troubles(session)],
  ];
  if (roundTrip !== undefined) list.push(["Round trip", ms(roundTrip)]);
  if (session.holdsLease) {
    const [half, most] = [milliseconds(session.ageP50), milliseconds(session.ageP99)];
    if (half !== undefined) list.push(["Age of its proxy", `${ms(half)}, 99 %: ${ms(most)}`]);
  }
  return list;
}

function roleWords({ role, holdsLease }: SessionLink): string {
  return role === Role.CONTROLLER && !holdsLease ? "lost the device" : ROLES[role] ?? "";
}

export function showSessions(links: readonly SessionLink[], device: string): void {
  const own = links.filter((link) => link.device === device);
  const items = own.map((link) => html`<li class=${link.holdsLease ? "lease" : ""}>
    <strong>${link.clientName}</strong> ${roleWords(link)}
    <dl class="facts">${facts(figures(link))}</dl></li>`);
  render(items.length === 0 ? html`<li>No session is open.</li>` : items, at("sessions"));
}
