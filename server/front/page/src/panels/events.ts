// "What happened": the newest events of the device.

import { Event_Kind, type Event } from "hapticd";
import { repeat } from "lit-html/directives/repeat.js";
import { at, html, render } from "../dom";
import { changeWords } from "../words";

const KEPT = 50;

export class Events {
  private told: { time: Date; words: string }[] = [];

  show(): void {
    this.told = [];
    this.draw();
  }

  add(event: Event): void {
    if (event.kind === Event_Kind.STALENESS) return; // several per second; a trace has it
    this.told = [{ time: new Date(), words: words(event) }, ...this.told].slice(0, KEPT);
    this.draw();
  }

  private draw(): void {
    const none = html`<li class="help">Nothing since this page opened.</li>`;
    render(this.told.length === 0 ? none : repeat(this.told, (one) => one, ({ time, words }) =>
      html`<li><time datetime=${time.toISOString()}>${time.toLocaleTimeString()}</time>
        <span>${words}</span></li>`), at("events"));
  }
}

function words({ kind, reason, message }: Event): string {
  const said = (kind === Event_Kind.STATE && changeWords(reason)) || message || reason;
  return said.charAt(0).toUpperCase() + said.slice(1);
}
