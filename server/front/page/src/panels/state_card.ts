// The card "State", and what the tool touches.

import { bitWords, type Device, type DeviceState } from "hapticd";
import { at, html, render, say } from "../dom";
import { number } from "../units";
import { contactWords, deratingWords, proxyWords, stateWords } from "../words";

/** A limit that acts for one tick is shown for this long, ms: people read slower. */
const SHOWN_MS = 700;

export class StateCard {
  private readonly card = at("state-card");
  private readonly gain = at<HTMLMeterElement>("gain");
  private readonly lastActed = new Map<number, number>();

  show(): void {
    this.lastActed.clear();
  }

  state(device: Device, state: DeviceState): void {
    const words = stateWords(state.state);
    this.card.dataset.tone = words.tone;
    say(at("state-title"), words.title);
    say(at("state-name"), words.name);
    say(at("state-help"), words.help);
    this.faults(state.faults);
    if (this.gain.value !== state.gain) this.gain.value = state.gain;
    say(at("gain-value"), `${number(state.gain * 100, 0)} %`);
    say(at("controller"), this.controller(device));
    say(at("proxy"), proxyWords(state));
    say(at("contact"), contactWords(state));
    say(at("derating"), deratingWords(device, state) || "As the scene sets it.");
    this.limiters(state.limiters);
  }

  private controller(device: Device): string {
    const tracker = device.tracker ? ` Its palm is tracked by “${device.tracker}”.` : "";
    const program = device.controller ? `“${device.controller}”.`
      : "No program yet. Start one, or feel a ball and a box (the link below the picture).";
    return program + tracker;
  }

  private faults(bits: number): void {
    render(bitWords("faults", bits).map(({ name, title, help }) => html`<div class="fault">
      <p><strong>${title}</strong> <code>${name}</code></p><p>${help}</p></div>`), at("faults"));
  }

  private limiters(bits: number): void {
    const now = performance.now();
    for (let bit = 0; bit < 32; bit++) if ((bits >>> bit) & 1) this.lastActed.set(bit, now);
    let shown = 0;
    for (const [bit, time] of this.lastActed) if (now - time < SHOWN_MS) shown |= 1 << bit;
    const items = bitWords("limiters", shown).map(({ name, title, help }) =>
      html`<li title=${help}>${title} <code>${name}</code></li>`);
    render(items.length === 0 ? "None." : html`<ul>${items}</ul>`, at("limiters"));
  }
}
