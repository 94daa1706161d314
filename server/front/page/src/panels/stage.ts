// The card "Device": the picture, its buttons, and what it says if it cannot be drawn.

import { at, say } from "../dom";
import type { Device, DeviceState } from "../model";
import { Picture, type Pose } from "../picture/picture";
import { quantity } from "../units";

const DRAG = 0.01; // rad per pixel

export class Stage {
  private readonly canvas = at<HTMLCanvasElement>("picture");
  private readonly picture: Picture | null;
  private device: Device | null = null;
  private shown = false;

  constructor() {
    this.picture = this.make();
    if (!this.picture) return;
    this.buttons(this.picture);
    this.drag(this.picture);
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
    const pose: Pose = state;
    if (this.shown) return this.picture.update(pose);
    this.shown = true;
    const step = this.picture.show(this.device.drawing, this.device.forceLimit, pose);
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
    const acts: Record<string, () => void> = {
      left: () => picture.view.turnStep(-1, 0),
      right: () => picture.view.turnStep(1, 0),
      up: () => picture.view.turnStep(0, 1),
      down: () => picture.view.turnStep(0, -1),
      in: () => picture.view.magnify(1.25),
      out: () => picture.view.magnify(0.8),
      reset: () => picture.view.reset(),
    };
    for (const button of document.querySelectorAll<HTMLElement>("[data-view]")) {
      button.addEventListener("click", () => {
        acts[button.dataset.view!]!();
        picture.ask();
      });
    }
  }

  /** A mouse turns it both ways; a finger from side to side, and scrolls the page up and down. */
  private drag(picture: Picture): void {
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!this.canvas.hasPointerCapture(event.pointerId)) return;
      const up = event.pointerType === "mouse" ? event.movementY * DRAG : 0;
      picture.view.turn(-event.movementX * DRAG, up);
      picture.ask();
    });
  }
}
