// A MuJoCo model as the page shows it, and the tool in it that the device moves.

import type { MainModule, MjData, MjModel } from "@mujoco/mujoco";
import type { Device } from "hapticd";
import { byName, Engine, Tool, type Binding } from "hapticd/mujoco";
import type { Geom } from "./messages";

const PLACE = 12; // numbers: position, matrix

export class World {
  readonly tool: Tool;
  private readonly model: MjModel;
  private readonly data: MjData;
  /** Where the joints would be if nothing were in their way; null: points cannot say it. */
  private readonly ghost: MjData | null;
  private readonly engine: Engine;
  private readonly bindings: Binding[];

  constructor(
    private readonly mujoco: MainModule,
    xml: string,
    device: Device,
    warn: (text: string) => void,
  ) {
    this.model = mujoco.MjModel.from_xml_string(xml);
    this.data = new mujoco.MjData(this.model);
    this.engine = new Engine(mujoco, this.model, this.data);
    this.bindings = byName(this.engine, device.coordinates);
    const coupling = this.engine.idOf("NUMERIC", "coupling");
    if (coupling < 0) throw new RangeError("the model has no numeric 'coupling'");
    const options = { coupling: this.model.numeric_data[this.model.numeric_adr[coupling]], warn };
    this.tool = new Tool(mujoco, this.model, this.data, this.bindings, options);
    const joints = this.bindings.every(({ kind }) => kind === "joint");
    this.ghost = joints ? new mujoco.MjData(this.model) : null;
  }

  /** Puts the world back as it was loaded. The tool notices, and comes to the probe again from
   * outside. */
  reset(): void {
    this.mujoco.mj_resetData(this.model, this.data);
  }
  /** Contacts that press the tool: their place, and the force on it, 6 numbers each; and what
   * presses it, by the name of the shape or else of its body. */
  presses(): { presses: Float32Array; touched: string[] } {
    const touched = new Set<string>();
    const presses = Float32Array.from(this.engine.contacts().flatMap((contact, i) => {
      const { geom1, geom2, efcAddress, pos, normal } = contact, second = this.moves(geom2);
      if (efcAddress < 0 || second === this.moves(geom1)) return [];
      const force = this.engine.normalForce(i) * (second ? 1 : -1);
      if (force === 0) return [];
      touched.add(this.nameOf(second ? geom1 : geom2));
      return [...pos, ...normal.map((part) => part * force)];
    }));
    return { presses, touched: [...touched] };
  }

  geoms(): Geom[] {
    const { model, mujoco: { mjtGeom } } = this;
    const types = new Map<number, Geom["type"]>([
      [mjtGeom.mjGEOM_PLANE.value, "plane"], [mjtGeom.mjGEOM_SPHERE.value, "sphere"],
      [mjtGeom.mjGEOM_CAPSULE.value, "capsule"], [mjtGeom.mjGEOM_ELLIPSOID.value, "ellipsoid"],
      [mjtGeom.mjGEOM_CYLINDER.value, "cylinder"], [mjtGeom.mjGEOM_BOX.value, "box"],
    ]);
    return Array.from({ length: model.ngeom }, (_, i) => {
      const type = types.get(model.geom_type[i]);
      if (!type) throw new RangeError(`geom ${i} is a mesh or a height field: not drawn here`);
      const material: number = model.geom_matid[i];
      const colours: Float32Array = material < 0 ? model.geom_rgba : model.mat_rgba;
      const at = 4 * (material < 0 ? i : material);
      return {
        type, tool: this.moves(i), free: this.freeBodyOf(i),
        size: [...model.geom_size.slice(3 * i, 3 * i + 3)] as Geom["size"],
        rgba: [...colours.slice(at, at + 4)] as Geom["rgba"],
      };
    });
  }
  /** Against gravity. */
  up(): [number, number, number] {
    const [x, y, z] = this.model.opt.gravity as Float64Array;
    const most = Math.max(...[x!, y!, z!].map(Math.abs));
    return most === 0 ? [0, 0, 1] : [-x! / most, -y! / most, -z! / most];
  }

  /** Position and matrix of every geom. */
  places(data = this.data): Float32Array {
    const positions: Float64Array = data.geom_xpos, turns: Float64Array = data.geom_xmat;
    const places = new Float32Array(PLACE * this.model.ngeom);
    for (let i = 0; i < this.model.ngeom; ++i) {
      places.set(positions.subarray(3 * i, 3 * i + 3), PLACE * i);
      places.set(turns.subarray(9 * i, 9 * i + 9), PLACE * i + 3);
    }
    return places;
  }
  /** Places of all geoms, with the tool at the device's pose; empty: not known. */
  placesOfProbe(xProbe: number[]): Float32Array {
    if (!this.ghost) return new Float32Array(0);
    const qpos: Float64Array = this.ghost.qpos;
    qpos.set(this.data.qpos);
    for (const { name, firstCoordinate, scale, offset } of this.bindings) {
      const joint = this.engine.idOf("JOINT", name);
      qpos[this.engine.fixed.jointPos[joint]!] = offset + scale * xProbe[firstCoordinate]!;
    }
    this.mujoco.mj_kinematics(this.model, this.ghost);
    return this.places(this.ghost);
  }
  pointsOfProbe(xProbe: number[]): Float32Array {
    return Float32Array.from(this.bindings.flatMap(({ kind, firstCoordinate: i }) =>
      kind === "joint" ? [] : xProbe.slice(i, i + 3)));
  }

  private freeBodyOf(geom: number): string {
    const { bodyJoint, bodyJoints, geomBody, jointType } = this.engine.fixed;
    const { mjtJoint } = this.mujoco, body = geomBody[geom]!;
    const free = bodyJoints[body]! > 0 &&
      jointType[bodyJoint[body]!] === mjtJoint.mjJNT_FREE.value && !this.moves(geom);
    return free ? this.bodyNameOf(geom) : "";
  }
  private nameOf(geom: number): string {
    return this.engine.nameOf("GEOM", geom) || this.bodyNameOf(geom);
  }
  /** Empty: it has none. */
  private bodyNameOf(geom: number): string {
    return this.engine.nameOf("BODY", this.engine.fixed.geomBody[geom] ?? 0);
  }
  private moves(geom: number): boolean {
    return geom >= 0 && this.tool.moves(this.engine.fixed.geomBody[geom]!);
  }
}
