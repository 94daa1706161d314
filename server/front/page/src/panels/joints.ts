// The table "Joints": where each DoF stands, and the force on it.

import type { Device, DeviceState } from "hapticd";
import { at, fill, h } from "../dom";
import { effortUnit, number, quantity } from "../units";

export function showJoints(device: Device, state: DeviceState): void {
  let actuators = 0;
  const rows = device.dofs.map(({ name, unit, actuated }, i) => {
    const position = quantity(state.q[i], unit);
    if (!actuated) return { name, position, force: "sensed only", share: null };
    const tau = state.tauA[actuators];
    const limit = device.forceLimit[actuators++] ?? 0;
    const share = limit > 0 && tau !== undefined ? Math.min(Math.abs(tau) / limit, 1) : 0;
    return { name, position, force: quantity(tau, effortUnit(unit)), share };
  });
  const meter = (share: number) => [
    h("meter", { value: String(share), "aria-hidden": "true" }),
    ` ${number(share * 100, 0)} %`,
  ];
  fill(at("joints"), rows, () =>
    rows.map(({ name, position, force, share }) =>
      h("tr", {}, h("th", { scope: "row" }, name), h("td", {}, position), h("td", {}, force),
        h("td", {}, ...(share === null ? [] : meter(share))))));
}
