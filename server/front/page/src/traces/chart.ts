// One trace: a heading, the newest values as legend, and uPlot's canvas.

import uPlot from "uplot";
import { colour, html, render } from "../dom";
import { number, withUnit } from "../units";
import { History } from "./history";
import { PALETTE, type Line, type Plan } from "./plans";

const HEIGHT = 150;
const DASH = [6, 4];
/** The longest window, s; and the rows kept: as much at 60 states per second, and some. */
const LONGEST = 60;
const ROWS = 4000;

/** Least span of a scale: less would show noise as if it were much. */
const LEAST: Record<string, number> = {
  N: 1,
  "N·m": 0.05,
  mm: 1,
  "°": 2,
  ms: 5,
  mJ: 0.5,
  "µs": 50,
};

/** Units whose scale may begin anywhere; others begin at 0. */
const WITHOUT_ZERO = ["mm", "°"];

/** A little air above and below; what is never below 0 is not shown below it. */
function range(
  _: uPlot,
  low: number | null,
  high: number | null,
  unit: string,
): uPlot.Range.MinMax {
  if (low === null || high === null) return [0, 1];
  const short = Math.max((LEAST[unit] ?? 1e-3) - (high - low), 0) / 2;
  const air = (high - low) * 0.1 + short;
  const zero = low >= 0 && (low < air || !WITHOUT_ZERO.includes(unit));
  return [zero ? 0 : low - air, high + air];
}

const swatch = ({ colour, dashed }: Line) => html`<span class="swatch ${dashed ? "dashed" : ""}"
  style="border-color: var(--line-${colour % PALETTE})" aria-hidden="true"></span>`;

export class Chart {
  readonly element = document.createElement("figure");
  readonly history: History;
  private readonly frame: HTMLElement;
  private plot: uPlot | null = null;
  private everHadValue = false;
  private held: (number | null)[][] | null = null;

  constructor(private readonly plan: Plan) {
    this.history = new History(plan.lines.length, ROWS);
    this.element.className = "trace";
    this.element.id = `trace-${plan.id}`;
    this.element.setAttribute("aria-labelledby", `title-${plan.id}`);
    this.show([]);
    this.frame = this.element.querySelector(".plot")!;
  }

  /** Keeps what is shown as it is at `now`, while the history goes on; null: goes on too. */
  hold(now: number | null): void {
    this.held = now === null ? null : this.history.window(now, LONGEST);
  }

  /** The last `seconds` before `now`, s. */
  draw(now: number, seconds: number): void {
    const rows = this.held ?? this.history.window(now, seconds);
    const last = rows.slice(1).map((column) => column.at(-1) ?? NaN);
    this.everHadValue ||= last.some(Number.isFinite);
    this.show(last);
    if (!this.everHadValue) return;
    if (!this.plot || this.plot.width !== this.frame.clientWidth) this.build();
    this.plot?.batch(() => {
      this.plot!.setData(rows as uPlot.AlignedData, false);
      this.plot!.setScale("x", { min: -seconds, max: 0 });
    });
  }

  /** Takes the plot away. The next draw makes another, in the colours that the page has then. */
  erase(): void {
    this.plot?.destroy();
    this.plot = null;
  }

  /** All but what uPlot draws. */
  private show(newest: readonly number[]): void {
    const { plan: { id, title, help, lines, absent }, everHadValue } = this;
    const value = (i: number, { digits, unit }: Line) => withUnit(number(newest[i], digits), unit);
    render(html`
      <figcaption>
        <h3 id="title-${id}">${title}</h3>
        <p class="help">${help}</p>
      </figcaption>
      <ul class="legend">${lines.map((line, i) => html`<li>${swatch(line)}
        <span>${line.label}</span><span class="value">${value(i, line)}</span></li>`)}</ul>
      <p class="absent" ?hidden=${everHadValue}>${absent}</p>
      <div class="plot" ?hidden=${!everHadValue}></div>`, this.element);
  }

  private build(): void {
    this.erase();
    const width = this.frame.clientWidth;
    this.plot = width > 0 ? new uPlot(this.options(width), [[]], this.frame) : null;
  }

  private options(width: number): uPlot.Options {
    const units = [...new Set(this.plan.lines.map((line) => line.unit))];
    const axis = {
      stroke: colour("--soft"),
      font: `11px ${getComputedStyle(document.body).fontFamily}`,
      grid: { stroke: colour("--rule"), width: 1 },
      ticks: { show: false },
    };
    return {
      width,
      height: HEIGHT,
      legend: { show: false },
      cursor: { show: false },
      scales: {
        x: { time: false, auto: false },
        ...Object.fromEntries(units.map((unit) => [unit, { range }])),
      },
      axes: [
        { ...axis, size: 24, values: (_, ticks) => ticks.map((tick) => `${number(tick, 0)} s`) },
        ...units.map((unit, i) => ({
          ...axis,
          scale: unit,
          side: i === 0 ? (3 as const) : (1 as const),
          size: 58,
          grid: { ...axis.grid, show: i === 0 },
          values: (_: uPlot, ticks: number[]) =>
            ticks.map((tick) => withUnit(String(+tick.toPrecision(6)).replace("-", "−"), unit)),
        })),
      ],
      series: [
        {},
        ...this.plan.lines.map((line) => ({
          scale: line.unit,
          stroke: colour(`--line-${line.colour % PALETTE}`),
          width: 2,
          points: { show: false },
          ...(line.dashed ? { dash: DASH } : {}),
        })),
      ],
    };
  }
}
