/** Tells people if the force that is told is not the one that holds the tool back. */
import type { Aim } from "./aim.js";
import { countOf } from "./binding.js";
import type { BoundTool } from "./bound_tool.js";
import type { Coupling } from "./coupling.js";
import type { Engine } from "./engine.js";

const FIRST = 0.2, EVERY = 1;  // s
const RESTS = 0.01;            // m/s
const MOST = 0.02;             // of what holds the tool back
const LEAST = 5e-4;            // rad or m of the coupling: less is not felt
const SMALL = 0.05;            // of the largest coordinate's: counts as this much
const NAMED = 3, MOST_SAID = 100;

export class HeldBack {
  private told: number[] = [];
  private held: number[] = [];
  private samples = 0;
  private left = FIRST;
  private rested = 0;  // s for which all points and poses are to rest
  private readonly said = new Set<string>();

  constructor(private readonly engine: Engine, private readonly tool: BoundTool,
              private readonly aim: Aim, private readonly coupling: Coupling,
              private readonly warn: (text: string) => void) {
    this.restart();
  }
  restart(): void {
    this.told = this.coupling.pulled.map(() => 0);
    this.held = [...this.told];
    this.samples = 0;
    this.left = FIRST;
  }

  /** A sample, after mj_step. `told`: the contacts' force that is told, N or N m per
   * coordinate. A second's mean of it is compared with that of the coupling's springs less what
   * moved masses take, the first time after 0.2 s. Warns if they differ by more than 2 %, once
   * of each contact. */
  look(told: number[]): void {
    const pulled = [...this.coupling.pulled];
    this.leaveOut(told, pulled);
    told.forEach((force, c) => { this.told[c]! += force; });
    pulled.forEach((force, c) => { this.held[c]! += force; });
    const smooth = this.engine.view("qfrc_smooth");
    const constraint = this.engine.view("qfrc_constraint");
    smooth.forEach((force, dof) => this.tool.coupled.way(dof)?.forEach((way, c) => {
      this.held[c]! -= way * (force + constraint[dof]!);
    }));
    ++this.samples;
    this.left -= this.aim.seconds;
    if (this.left > 0) return;
    this.compare();
    this.restart();
    this.left = EVERY;
  }
  /** Leaves out what is not known: turns, and positions while a point or pose moves. */
  private leaveOut(told: number[], pulled: number[]): void {
    const frames = this.tool.places.map(({ binding }) => binding)
      .filter(({ kind }) => kind !== "joint");
    const rests = frames.every(({ firstCoordinate: first }) =>
      [0, 1, 2].every((k) => Math.abs(this.aim.rate(first + k)) <= RESTS));
    this.rested = rests ? this.rested + this.aim.seconds : 0;
    for (const { firstCoordinate: first, kind } of frames) {
      const known = this.rested < FIRST ? 0 : 3;
      for (let k = known; k < countOf(kind); ++k) told[first + k] = pulled[first + k] = 0;
    }
  }

  private compare(): void {
    const way = (force: number, c: number) =>
      Math.abs(force) / this.samples / this.coupling.stiffness(c);
    const most = Math.max(...this.held.map(way));
    const parts = this.held.map((held, c) =>
      way(this.told[c]! - held, c) / Math.max(way(held, c), SMALL * most, LEAST));
    const worst = Math.max(...parts), at = parts.indexOf(worst);
    if (!(worst > MOST)) return;
    const where = this.touched(at), key = where + at;
    if (this.said.size >= MOST_SAID || this.said.has(key)) return;
    this.said.add(key);
    const [told, held] = [this.told[at]! / this.samples, this.held[at]! / this.samples];
    const name = this.tool.places.find(({ binding: { firstCoordinate: first, kind } }) =>
      at >= first && at < first + countOf(kind))?.binding.name;
    this.warn("what is told is not what holds the tool back, but " +
      `${(told / held).toFixed(2)} of it at coordinate ${at}, '${name}' ` +
      `(${told.toPrecision(3)} of ${held.toPrecision(3)} N or N m): ${where}`);
  }
  /** True if a body is the tool's, and a joint's coordinate moves it; any of a point or pose. */
  private isMoved(body: number, coordinate: number): boolean {
    const { fixed: { bodyDof, bodyDofs, bodyParent } } = this.engine, { coupled } = this.tool;
    if (!this.tool.moves(body)) return false;
    const joints = this.tool.places.some(({ binding: { firstCoordinate, kind } }) =>
      kind === "joint" && firstCoordinate === coordinate);
    for (; body > 0 && joints; body = bodyParent[body]!) {
      for (let k = 0; k < bodyDofs[body]!; ++k) {
        if (coupled.way(bodyDof[body]! + k)?.[coordinate]) return true;
      }
    }
    return !joints;
  }
  /** Names of what touches the tool where the coordinate moves it, and what else may hold it. */
  private touched(at: number): string {
    const { engine: { fixed: { geomBody } }, tool } = this;
    const ofTool = (geom: number) => this.isMoved(geomBody[geom]!, at);
    const all = this.engine.contacts().filter(({ efcAddress, geom1: a, geom2: b }) =>
      efcAddress >= 0 && a >= 0 && b >= 0 && (ofTool(a) || ofTool(b)));
    const pairs = [...new Set(all.map(({ geom1, geom2 }) =>
      `${this.engine.nameOfGeom(geom1)} on ${this.engine.nameOfGeom(geom2)}`))];
    let text = pairs.slice(0, NAMED).join(", ") || "nothing touches it";
    if (pairs.length > NAMED) text += ` and ${pairs.length - NAMED} more`;
    const friction = all.some(({ dim }) => dim > 1);
    const driven = this.engine.view("qfrc_actuator").some(
      (force, dof) => force !== 0 && tool.coupled.way(dof) !== undefined);
    if (friction) text += "; friction is not told";
    if (driven) text += "; actuators are not told";
    return friction || driven ? text
      : `${text}; a weld, a limit or a force of the model is not told`;
  }
}
