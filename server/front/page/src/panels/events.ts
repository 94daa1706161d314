// "What happened": the newest events of the device.

import { Event_Kind, type Event } from "hapticd";
import { at, h } from "../dom";
import { changeWords } from "../words/state";

const KEPT = 50;

export class Events {
  private readonly list = at("events");

  show(): void {
    this.list.replaceChildren(h("li", { class: "help" }, "Nothing since this page opened."));
  }

  add(event: Event): void {
    if (event.kind === Event_Kind.STALENESS) return; // several per second; a trace has it
    if (!this.list.querySelector("time")) this.list.replaceChildren();
    const now = new Date();
    const time = h("time", { datetime: now.toISOString() }, now.toLocaleTimeString());
    this.list.prepend(h("li", {}, time, h("span", {}, words(event))));
    while (this.list.childElementCount > KEPT) this.list.lastElementChild!.remove();
  }
}

function words({ kind, reason, message }: Event): string {
  const said = (kind === Event_Kind.STATE && changeWords(reason)) || message || reason;
  return said.charAt(0).toUpperCase() + said.slice(1);
}
