// Which device is shown. The address remembers it: #device=NAME.

import type { Device } from "hapticd";
import { at, html, render } from "../dom";

const KEY = "device";

function remembered(): string {
  return new URLSearchParams(location.hash.slice(1)).get(KEY) ?? "";
}

export class Chooser {
  private readonly select = at<HTMLSelectElement>("chooser");

  constructor(chosen: (name: string) => void) {
    this.select.addEventListener("change", () => {
      location.hash = new URLSearchParams({ [KEY]: this.select.value }).toString();
    });
    addEventListener("hashchange", () => {
      if ([...this.select.options].some(({ value }) => value === remembered())) {
        this.select.value = remembered();
        chosen(this.select.value);
      }
    });
  }

  /** The device that the address names, else the first. */
  offer(devices: readonly Device[]): Device | undefined {
    render(devices.map(({ name }) => html`<option value=${name}>${name}</option>`), this.select);
    at("chooser-label").hidden = devices.length < 2;
    const chosen = devices.find(({ name }) => name === remembered()) ?? devices[0];
    if (chosen) this.select.value = chosen.name;
    return chosen;
  }
}
