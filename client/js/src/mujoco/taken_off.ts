/** Switches off what a model itself does with joints that the device moves. */
import type { BoundTool } from "./bound_tool.js";
import type { Engine } from "./engine.js";

const NO_LIMIT = 1e9;

export class TakenOff {
  private readonly wraps: { type: number; id: number }[][];

  constructor(private readonly engine: Engine, private readonly tool: BoundTool) {
    const { model } = engine;
    const begins: number[] = Array.from(model.tendon_adr), counts = model.tendon_num;
    this.wraps = begins.map((first, i) => Array.from({ length: counts[i] }, (_, k) =>
      ({ type: model.wrap_type[first + k], id: model.wrap_objid[first + k] })));
  }
  /** Switches off in the model: limits and friction of joints that are bound or that constraints
   * lead, friction of their tendons. The hand that wears the device is where it is. */
  limits(): void {
    const { engine: { fixed, model }, tool: { coupled } } = this;
    fixed.dofJoint.forEach((joint, dof) => {
      if (!coupled.bound(dof) && !coupled.led(dof)) return;
      // Far away, not off: @mujoco/mujoco 3.14.0 throws at a look at jnt_limited.
      model.jnt_range.set([-NO_LIMIT, NO_LIMIT], 2 * joint);
      model.dof_frictionloss[dof] = 0;
    });
    this.wraps.forEach((_, tendon) => {
      if (this.movesTendon(tendon)) model.tendon_frictionloss[tendon] = 0;
    });
  }
  /** Switches off the actuators on joints that the device moves. Their names; empty: none. */
  actuators(): string {
    const { engine: { mj, model } } = this, names: string[] = [];
    for (let i = 0; i < model.nu; ++i) {
      if (!this.movesActuator(i)) continue;
      names.push(this.nameOf(i));
      model.actuator_gaintype[i] = mj.mjtGain.mjGAIN_FIXED.value;
      model.actuator_biastype[i] = mj.mjtBias.mjBIAS_NONE.value;
      const each = model.actuator_gainprm.length / model.nu;
      model.actuator_gainprm.fill(0, each * i, each * (i + 1));
    }
    return names.join(", ");
  }

  private nameOf(actuator: number): string {
    const { mj, model } = this.engine, name = this.engine.nameOf("ACTUATOR", actuator);
    if (name) return `'${name}'`;
    const onJoint = model.actuator_trntype[actuator] === mj.mjtTrn.mjTRN_JOINT.value;
    const joint = onJoint && this.engine.nameOf("JOINT", model.actuator_trnid[2 * actuator]);
    return joint ? `that of joint '${joint}'` : `number ${actuator}`;
  }
  private movesJoint(joint: number): boolean {
    return this.tool.coupled.way(this.engine.fixed.jointDof[joint]!) !== undefined;
  }
  private movesTendon(tendon: number): boolean {
    const { mjWRAP_JOINT, mjWRAP_SITE } = this.engine.mj.mjtWrap;
    return this.wraps[tendon]!.some(({ type, id }) =>
      (type === mjWRAP_JOINT.value && this.movesJoint(id)) ||
      (type === mjWRAP_SITE.value && this.tool.moves(this.engine.fixed.siteBody[id]!)));
  }
  private movesActuator(actuator: number): boolean {
    const { model, fixed, mj: { mjtTrn } } = this.engine;
    const type = model.actuator_trntype[actuator], id = model.actuator_trnid[2 * actuator];
    const joints: number[] = [mjtTrn.mjTRN_JOINT.value, mjtTrn.mjTRN_JOINTINPARENT.value];
    const sites: number[] = [mjtTrn.mjTRN_SITE.value, mjtTrn.mjTRN_SLIDERCRANK.value];
    if (joints.includes(type)) return this.movesJoint(id);
    if (type === mjtTrn.mjTRN_TENDON.value) return this.movesTendon(id);
    return sites.includes(type) && this.tool.moves(fixed.siteBody[id]!);
  }
}
