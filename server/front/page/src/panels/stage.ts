// The card "Device": the picture, its buttons, and what it says if it cannot be drawn.

import type { Device, DeviceState } from "hapticd";
import { at, html, render, say } from "../dom";
import { Picture } from "../picture/picture";
import type { View } from "../picture/view";
import { quantity } from "../units";

/** Sign, meaning, and act. */
const BUTTONS: [string, string, (view: View) => void][] = [
  ["◀", "Turn left", (view) => view.turnStep(-1, 0)],
  ["▶", "Turn right", (view) => view.turnStep(1, 0)],
  ["▲", "Turn up", (view) => view.turnStep(0, 1)],
  ["▼", "Turn down", (view) => view.turnStep(0, -1)],
  ["+", "Nearer", (view) => view.magnify(1.25)],
  ["−", "Farther", (view) => view.magnify(0.8)],
  ["Reset", "Reset", (view) => view.reset()],
];

export class Stage {
  private readonly canvas = at<HTMLCanvasElement>("picture");
  private readonly picture: Picture | null;
  private device: Device | null = null;
  private shown = false;

  constructor() {
    this.picture = this.make();
    if (this.picture) this.buttons(this.picture);
  }

  show(device: Device): void {
    this.device = device;
    this.shown = false;
    this.picture?.clear();
    say(at("picture-title"), device.name);
    const bodies = device.drawing?.bodies.length ?? 0;
    if (this.picture && bodies === 0) this.refuse("There is no drawing of this kind of device.");
    else if (this.picture) this.refuse("");
  }

  state(state: DeviceState): void {
    if (!this.picture || !this.device?.drawing || state.q.length === 0) return;
    if (this.shown) return this.picture.update(state);
    this.shown = true;
    const step = this.picture.show(this.device.drawing, this.device.forceLimit, state);
    say(at("grid-size"), `one square is ${quantity(step, "m").replace(".0 ", " ")}`);
  }

  private make(): Picture | null {
    try {
      return new Picture(this.canvas);
    } catch {
      this.refuse("This browser has no WebGL, so there is no picture. All else works.");
      return null;
    }
  }

  private refuse(why: string): void {
    say(at("no-picture"), why);
    at("no-picture").hidden = why === "";
    this.canvas.hidden = why !== "";
    at("picture-legend").hidden = why !== "";
    at("view-buttons").hidden = why !== "";
    at("stage").classList.toggle("empty", why !== "");
  }

  private buttons(picture: Picture): void {
    const press = (act: (view: View) => void) => () => {
      act(picture.view);
      picture.ask();
    };
    render(BUTTONS.map(([sign, what, act]) => html`<button type="button" aria-label=${what}
      @click=${press(act)}>${sign}</button>`), at("view-buttons"));
  }
}
