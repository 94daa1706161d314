// The table "Joints": where each DoF stands, and the force on it.

import { effortUnit, type Device, type DeviceState } from "hapticd";
import { at, html, render } from "../dom";
import { number, quantity } from "../units";

const meter = (share: number) => html`<meter value=${share} aria-hidden="true"></meter>
  ${number(share * 100, 0)} %`;

export function showJoints(device: Device, state: DeviceState): void {
  let actuators = 0;
  const cells = device.dofs.map(({ unit, actuated }) => {
    if (!actuated) return ["sensed only", ""] as const;
    const tau = state.tauA[actuators];
    const limit = device.forceLimit[actuators++] ?? 0;
    const share = limit > 0 && tau !== undefined ? Math.min(Math.abs(tau) / limit, 1) : 0;
    return [quantity(tau, effortUnit(unit)), meter(share)] as const;
  });
  render(device.dofs.map(({ name, unit }, i) => html`<tr>
    <th scope="row">${name}</th><td>${quantity(state.q[i], unit)}</td>
    <td>${cells[i]![0]}</td><td>${cells[i]![1]}</td></tr>`), at("joints"));
}
