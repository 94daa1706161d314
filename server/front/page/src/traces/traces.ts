// All traces of a device: how long they are, and whether they stand still.

import type { Device, DeviceState, GetServerInfoResponse } from "hapticd";
import { at, say } from "../dom";
import { Chart } from "./chart";
import { LATENESS, lateness, plans, type StatePlan } from "./plans";

/** Times per second that the traces are drawn: long ones move slowly. */
function rate(seconds: number, still: boolean): number {
  if (still) return 1; // the person asked the system for less motion
  return seconds > 30 ? 5 : 15;
}

export class Traces {
  private charts: { chart: Chart; plan: StatePlan }[] = [];
  private readonly late = new Chart(LATENESS);
  private readonly holder = at("traces");
  private readonly pauseButton = at<HTMLButtonElement>("pause");
  private readonly still = matchMedia("(prefers-reduced-motion: reduce)");
  private seconds = 10;
  private paused = false;
  private newest = 0;
  private drawn = 0;

  constructor() {
    this.pauseButton.addEventListener("click", () => this.pause(!this.paused));
    for (const choice of document.querySelectorAll<HTMLInputElement>("input[name=window]")) {
      choice.addEventListener("change", () => {
        this.seconds = Number(choice.value);
        this.drawn = 0;
      });
    }
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      for (const chart of this.all()) chart.erase();
      this.drawn = 0;
    });
    const frame = (now: number): void => {
      requestAnimationFrame(frame);
      if (now - this.drawn < 1000 / rate(this.seconds, this.still.matches)) return;
      this.drawn = now;
      this.draw();
    };
    requestAnimationFrame(frame);
  }

  show(device: Device): void {
    for (const { chart } of this.charts) chart.erase();
    this.charts = plans(device).map((plan) => ({ plan, chart: new Chart(plan) }));
    this.holder.replaceChildren(...this.all().map((chart) => chart.element));
    this.newest = 0;
    this.pause(false);
  }

  state(state: DeviceState): void {
    const time = Number(state.serverTimeNs) * 1e-9;
    // A server that started again counts from elsewhere.
    if (time < this.newest - 1) for (const chart of this.all()) chart.history.clear();
    for (const { chart, plan } of this.charts) chart.history.push(time, plan.sample(state));
    this.newest = time;
  }

  server(info: GetServerInfoResponse): void {
    if (this.newest > 0) this.late.history.push(this.newest, lateness(info));
  }

  /** The stream of states was interrupted. */
  cut(): void {
    for (const { chart } of this.charts) chart.history.cut();
  }

  private all(): Chart[] {
    return [...this.charts.map(({ chart }) => chart), this.late];
  }

  private pause(on: boolean): void {
    this.paused = on;
    for (const chart of this.all()) chart.hold(on ? this.newest : null);
    this.pauseButton.setAttribute("aria-pressed", String(on));
    say(this.pauseButton, on ? "Go on" : "Pause");
    this.holder.classList.toggle("paused", on);
    this.drawn = 0;
  }

  private draw(): void {
    if (document.hidden) return;
    for (const chart of this.all()) chart.draw(this.newest, this.seconds);
  }
}
