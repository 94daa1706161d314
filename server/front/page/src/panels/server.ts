// The card "Server".

import type { Device, GetServerInfoResponse } from "hapticd";
import { at, facts, render, say } from "../dom";
import { howLong, number } from "../units";

const GUARDS: Record<string, string> = {
  direction_guard: "no direction guard",
  energy_tank: "no energy tank",
};

function deviceWords(device: Device): string {
  const parts = [device.model ? `${device.kind}, ${device.model}` : device.kind];
  if (!device.moves) parts.push("forces are computed, nothing moves");
  if (device.calibrated) parts.push(`calibrated on ${device.calibrated}`);
  parts.push(...device.unguarded.map((name) => GUARDS[name] ?? `no ${name}`));
  return parts.join("; ");
}

export function showServer(info: GetServerInfoResponse, device: Device): void {
  say(at("scene"), `· ${info.scene}`);
  const { loop, realtime } = info;
  const us = (value: number) => `${number(value, 0)} µs`;
  const grant = [realtime?.grade, realtime?.explanation].filter(Boolean).join(": ");
  const list: [string, string][] = [
    ["Version", info.version],
    ["Device", deviceWords(device)],
    ["Runs for", howLong(Number(info.uptime?.seconds ?? 0n))],
    ["Real time", grant || "–"],
  ];
  if (loop) {
    list.push(
      ["Loop wakes late", `99 %: ${us(loop.latenessP99Us)}, worst ${us(loop.latenessMaxUs)}`],
      ["Loop computes", `99 %: ${us(loop.tickP99Us)} of each tick`],
      ["Ticks skipped", String(loop.skipped)],
    );
  }
  list.push(["Sessions", `${info.sessions} of ${info.maxSessions}`]);
  list.push(["Not protected", info.insecure.join(" ") || "nothing"]);
  render(facts(list), at("server"));
}
