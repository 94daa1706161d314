// The table "Joints": where each DoF stands, and the force on it.

import type { Device, DeviceState } from "hapticd";
import { at, h, say } from "../dom";
import { effortUnit, number, quantity } from "../units";

interface Row {
  dof: number;
  actuator: number; // index in tau_a; -1: sensed only
  position: HTMLElement;
  force: HTMLElement;
  share: HTMLElement;
  bar: HTMLMeterElement;
}

export class Joints {
  private rows: Row[] = [];

  show(device: Device): void {
    let actuators = 0;
    this.rows = device.dofs.map((dof, i) => ({
      dof: i,
      actuator: dof.actuated ? actuators++ : -1,
      position: h("td"),
      force: h("td"),
      share: h("span"),
      bar: h("meter", { "aria-hidden": "true" }),
    }));
    at("joints").replaceChildren(
      ...this.rows.map((row) => {
        const share = row.actuator < 0 ? h("td") : h("td", {}, row.bar, " ", row.share);
        if (row.actuator < 0) row.force.textContent = "sensed only";
        const name = h("th", { scope: "row" }, device.dofs[row.dof]!.name);
        return h("tr", {}, name, row.position, row.force, share);
      }),
    );
  }

  state(device: Device, state: DeviceState): void {
    for (const { dof, actuator, position, force, share, bar } of this.rows) {
      const { unit } = device.dofs[dof]!;
      say(position, quantity(state.q[dof], unit));
      if (actuator < 0) continue;
      const tau = state.tauA[actuator];
      const limit = device.forceLimit[actuator] ?? 0;
      const part = limit > 0 && tau !== undefined ? Math.min(Math.abs(tau) / limit, 1) : 0;
      say(force, quantity(tau, effortUnit(unit)));
      say(share, `${number(part * 100, 0)} %`);
      bar.value = part;
    }
  }
}
