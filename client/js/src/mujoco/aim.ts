/** Where the tool is to be, step by step: at the probe at the end of each sample's period, or on
 * the way there if the probe jumped. */
import type { BoundTool } from "./bound_tool.js";
import type { Jumps } from "./options.js";

export class Aim {
  private from: number[] = [];
  private to: number[] = [];
  private part = 1;
  private steps = 1;
  private taken = 1;
  /** Time of all steps. */
  seconds = 1;
  following = false;

  constructor(private readonly tool: BoundTool, private readonly options: Jumps) {}

  /** The tool is at x, and does not follow. */
  begin(x: number[]): void {
    this.from = [...x];
    this.to = [...x];
    this.following = false;
  }
  /** The next `steps` steps, of `seconds` in all, go to `probe`; empty: they stay. */
  next(probe: number[], steps: number, seconds: number): void {
    this.from = [...this.to];
    this.steps = steps;
    this.taken = 0;
    this.part = 0;
    this.seconds = seconds;
    if (probe.length === 0) return;
    const goal = [...probe];
    while (this.from.length < goal.length) this.from.push(0);
    const part = this.partOfWay(goal);
    this.to = goal.map((value, i) => this.from[i]! + part * (value - this.from[i]!));
    this.following = part === 1;
  }
  /** One step more; beyond the last the aim stays. */
  step(): void {
    this.taken = Math.min(this.taken + 1, this.steps);
    this.part = this.taken / this.steps;
  }
  /** Coordinate i now; a quaternion's parts are to be normalised. */
  at(i: number): number {
    return this.from[i]! + this.part * (this.to[i]! - this.from[i]!);
  }
  rate(i: number): number {
    return (this.to[i]! - this.from[i]!) / this.seconds;
  }

  /** The part of the way to the goal that is gone in this period, 1: all of it. Writes angles and
   * quaternions of the goal as near to the aim as they can be said. */
  private partOfWay(goal: number[]): number {
    let jump = 0, slow = 0;  // of the largest that is allowed at once, and of a slow period
    const { from, options } = this;
    const count = (way: number, turns: boolean): void => {
      jump = Math.max(jump, way / (turns ? options.jumpRad : options.jumpM));
      slow = Math.max(slow, way / (this.seconds * (turns ? options.slowRadS : options.slowMS)));
    };
    for (const place of this.tool.places) {
      const { kind, firstCoordinate: first } = place.binding;
      if (kind === "joint") {
        goal[first] = from[first]! + place.apart(from[first]!, goal[first]!);
        count(Math.abs(goal[first]! - from[first]!), place.turns);
        continue;
      }
      const way = (i: number) => goal[i]! - from[i]!;
      count(Math.hypot(way(first), way(first + 1), way(first + 2)), false);
      if (kind === "point") continue;
      const q = goal.slice(first + 3, first + 7), length = Math.hypot(...q);
      const same = q.reduce((sum, part, i) => sum + part * from[first + 3 + i]!, 0);
      q.forEach((part, i) => { goal[first + 3 + i] = (same < 0 ? -part : part) / length; });
      count(2 * Math.acos(Math.min(Math.abs(same) / length, 1)), true);
    }
    if (jump <= 1 && this.following) return 1;
    return slow <= 1 ? 1 : 1 / slow;
  }
}
