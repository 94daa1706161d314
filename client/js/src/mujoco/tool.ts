/** The part of a MuJoCo model that the device moves. */
import { contactAt, contactHorizon } from "../contact.js";
import { Proxy } from "../proxy.js";
import type { Plane } from "../proxy.js";
import { Aim } from "./aim.js";
import type { Binding } from "./binding.js";
import { BoundTool } from "./bound_tool.js";
import { Coupling } from "./coupling.js";
import { Engine } from "./engine.js";
import type { MainModule, MjData, MjModel } from "./engine.js";
import { HeldBack } from "./held_back.js";
import { Margins } from "./margins.js";
import { NearContacts } from "./near_contacts.js";
import { JUMPS } from "./options.js";
import type { Jumps, ToolOptions } from "./options.js";
import { TakenOff } from "./taken_off.js";

const RISE = 0.2;  // s, as the server's gain (proto/README.md, Staleness and gain)

/** Leaves `share` of the force that the contact has alone: of its spring in series with the
 * coupling, and of its object, which moves as before. `gives`: the square of the normal's length,
 * in W^-1. */
function soften(plane: Plane, gives: number, share: number): Plane {
  const { compliance = 0, mass = 0, damping = 0, groundStiffness = 0, load = 0 } = plane;
  return {
    ...plane, compliance: (compliance + gives) / share - gives, mass: share * mass,
    damping: share * damping, groundStiffness: share * groundStiffness, load: share * load,
  };
}

/** All bodies below a bound one, and those that bound joints move by way of equalities and tendons.
 * Contacts of their geoms with anything else, and with each other, are told. */
export class Tool {
  readonly #engine: Engine;
  readonly #options: ToolOptions & Jumps;
  readonly #tool: BoundTool;
  readonly #contacts: NearContacts;
  readonly #aim: Aim;
  readonly #margins: Margins;
  readonly #coupling: Coupling;
  readonly #heldBack: HeldBack;
  #probe: number[] = [];       // of the newest state, all coordinates
  #seen: number[] = [];        // the tool as the last step began
  #rate = new Float64Array(0); // qvel then
  #known = false;              // the last probe could be used
  #share = 0;                  // of the force that is told, 0 to 1
  #lastTime = 0;               // as the last step began, s
  #lastStep = 0;               // s
  #owed = 0;                   // s
  #room = 1;                   // share of the horizon for which MuJoCo has room
  #timesFull = 0;
  #timesBad = 0;

  /** `model` and `data` stay the caller's, and must live longer. Changes in `model`: limits,
   * friction and actuators of the tool's joints are off, and the gap of the tool's geoms grows
   * by the horizon in which contacts are told, without a change of where force begins. A second
   * joint of a coordinate may get armature. In `data` qfrc_applied of the tool's DoFs is the
   * tool's: put forces of your own into xfrc_applied. Runs mj_forward.
   *
   * Throws RangeError, which names binding, value and what is allowed: an unknown name, a joint
   * that is bound twice, a coordinate that is so but by joints, has no weight or is not below
   * 10000, a ball or free joint, a scale of 0, a coupling or a weight that is not above 0, and
   * a spring too stiff for the model's step (step sqrt(c w / m) > 0.5). */
  constructor(mujoco: MainModule, model: MjModel, data: MjData, bindings: Binding[],
              options: ToolOptions) {
    mujoco.mj_forward(model, data);
    this.#engine = new Engine(mujoco, model, data);
    this.#options = { ...JUMPS, ...options };
    this.#tool = new BoundTool(this.#engine, bindings, options);
    this.#contacts = new NearContacts(this.#engine, this.#tool);
    this.#aim = new Aim(this.#tool, this.#options);
    this.#margins = new Margins(this.#engine, this.#tool);
    this.#coupling = new Coupling(this.#engine, this.#tool, this.#aim, this.#options);
    this.#heldBack = new HeldBack(this.#engine, this.#tool, this.#aim, this.#coupling,
                                  (text) => this.#warn(text));
    const takenOff = new TakenOff(this.#engine, this.#tool);
    takenOff.limits();
    const off = options.keepActuators ? "" : takenOff.actuators();
    if (off !== "") {
      this.#warn(`the device moves joints that have actuators in the model; these are off: ` +
        `${off} (keepActuators leaves them on)`);
    }
    this.restart();
  }
  /** Gives WebAssembly's memory back; `model` and `data` stay. */
  delete(): void {
    this.#engine.delete();
  }

  /** True if the tool follows the probe; false: it is on its way there, see Jumps. */
  get following(): boolean {
    return this.#aim.following;
  }
  /** True if a body is the tool's. */
  moves(body: number): boolean {
    return this.#tool.moves(body);
  }

  /** `periodMs` of simulated time by mj_step, and the sample to publish. `xProbe`: of the newest
   * state, all coordinates of the device; if it is empty, not finite, or a pose's quaternion is
   * shorter than 1e-3, the tool stays where it is, and the sample is Proxy.free(). `roundTripMs`:
   * Session.roundTripMs, for the horizon in which contacts are told before they touch. */
  step(xProbe: number[], periodMs: number, roundTripMs = 0): Proxy {
    const { mj, model, data, opt: { timestep: step } } = this.#engine;
    this.#owed += periodMs / 1000;
    const count = Math.max(1, Math.floor(this.#owed / step + 1e-6));
    this.#owed -= count * step;
    this.aim(xProbe, count, roundTripMs);
    for (let i = 0; i < count; ++i) {
      this.pull();
      mj.mj_step(model, data);
    }
    return this.proxy();
  }

  // The same in parts, for a loop that calls mj_step itself:
  //   tool.aim(xProbe, 16, session.roundTripMs);
  //   for (let i = 0; i < 16; ++i) { tool.pull(); mujoco.mj_step(model, data); }
  //   session.publish(tool.proxy());

  /** Where the tool is to be after `steps` (> 0) steps. */
  aim(xProbe: number[], steps: number, roundTripMs = 0): void {
    if (!(steps > 0)) throw new RangeError(`steps ${steps}: must be > 0`);
    this.#lookForJump();
    const { mj, opt } = this.#engine, seconds = steps * opt.timestep;
    // The probe may be deep inside an object as the tool arrives: from FREE force comes by a ramp.
    this.#share = this.#known && this.following ? Math.min(1, this.#share + seconds / RISE) : 0;
    this.#known = false;
    if (xProbe.length === 0 || !xProbe.every(Number.isFinite)) {
      return this.#aim.next([], steps, seconds);
    }
    const { coordinates } = this.#tool, weights = this.#options.weights?.length ?? xProbe.length;
    if (xProbe.length < coordinates) {
      throw new RangeError(`xProbe has ${xProbe.length} coordinates, and coordinate ` +
        `${coordinates - 1} is bound`);
    }
    if (weights !== xProbe.length) {
      throw new RangeError(
        `xProbe has ${xProbe.length} coordinates, but there are ${weights} weights`);
    }
    if (!this.#tool.hasTurns(xProbe)) return this.#aim.next([], steps, seconds);
    this.#known = true;
    this.#probe = [...xProbe];
    this.#aim.next(this.#probe, steps, seconds);
    // A list that is full has lost contacts, perhaps some that are touched.
    const full = this.#engine.warnings(mj.mjtWarning.mjWARN_CONTACTFULL.value);
    if (full > this.#timesFull) this.#room *= 0.5;
    this.#timesFull = full;
    this.#margins.grow(this.#room * contactHorizon(roundTripMs, seconds * 1000));
  }

  /** Sets qfrc_applied for the next mj_step. Before every one: after a step without it the tool
   * begins again, see restart(). */
  pull(): void {
    this.#lookForJump();
    const { mj, model, data } = this.#engine;
    mj.mj_kinematics(model, data);
    mj.mj_comPos(model, data);
    this.#seen = [...this.#probe];
    this.#tool.read(this.#seen);
    this.#rate = this.#engine.view("qvel").slice();
    this.#lastTime = data.time;
    this.#lastStep = this.#engine.opt.timestep;
    this.#aim.step();
    this.#coupling.pull(this.#seen, this.#rate);
  }

  /** The proxy of the contacts that the last mj_step found. */
  proxy(): Proxy {
    this.#lookForJump();
    this.#tool.look();
    const near = this.#contacts.find(this.#seen, this.#rate), { coupling } = this.#options;
    const share = this.#share;
    if (!this.#known || !this.following || share === 0) return Proxy.free();
    const x = [...this.#probe], planes: Plane[] = [], told = this.#coupling.pulled.map(() => 0);
    for (const { contact, force } of near) {
      const plane = contactAt(this.#seen, contact, coupling);
      if (plane.normal.every((part) => part === 0)) continue;
      let gives = 0;
      plane.normal.forEach((part, i) => {
        const stiffness = this.#coupling.stiffness(i);
        x[i]! -= share * part * force / stiffness;
        gives += part * part * coupling / stiffness;
        if (i < told.length) told[i]! += part * force;
      });
      planes.push(share < 1 ? soften(plane, gives, share) : plane);
    }
    if (share < 1) this.#heldBack.restart();
    else this.#heldBack.look(told);
    // The half spaces as they were seen, with the normals by which x was displaced: joints and
    // friction keep the tool from x, and around x the object curves otherwise.
    return planes.length === 0 ? Proxy.free() : Proxy.behind(planes, x);
  }

  /** The tool begins again where the model has it, as a late join: until it came to the probe, see
   * Jumps, nothing is told, and what it is inside of does not count. Call it after you moved the
   * model yourself (qpos). It happens by itself if data.time is not that of the next step: after
   * mj_resetData, a key of another time, a bad state, or steps without pull(). Runs mj_forward. */
  restart(): void {
    const { mj, model, data } = this.#engine;
    this.#margins.grow(0);
    mj.mj_forward(model, data);
    this.#probe = Array<number>(this.#tool.coordinates).fill(0);
    this.#tool.look();
    this.#tool.read(this.#probe);
    this.#heldBack.restart();
    this.#seen = [...this.#probe];
    this.#aim.begin(this.#probe);
    this.#rate = new Float64Array(model.nv);
    this.#contacts.begin();
    this.#lastTime = data.time;
    this.#lastStep = this.#engine.opt.timestep;
    this.#timesBad = this.#engine.badStates();
    this.#timesFull = this.#engine.warnings(mj.mjtWarning.mjWARN_CONTACTFULL.value);
  }

  /** Restarts if the model is not where a step from the last pull() brought it. */
  #lookForJump(): void {
    const step = this.#engine.data.time - this.#lastTime;
    if (step < 0 || step >= 1.5 * this.#lastStep) return this.restart();
    // From a bad state MuJoCo begins again at 0, which is not a jump as the first steps end. Only
    // then look at its warnings, which takes long here.
    const first = this.#lastTime <= 1.5 * this.#lastStep;
    if (first && this.#engine.badStates() !== this.#timesBad) this.restart();
  }

  #warn(text: string): void {
    const { warn = console.warn } = this.#options;
    warn(text);
  }
}
