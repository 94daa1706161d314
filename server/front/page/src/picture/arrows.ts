// The force of each actuator: a straight arrow for a force, a bent one for a torque. Its size is
// the share of the actuator's limit.

import type { DrawnForce, Drawing } from "hapticd";
import {
  ConeGeometry, CylinderGeometry, Group, Mesh, Quaternion, TorusGeometry, Vector3, type Material,
} from "three";
import { vector, type Frames } from "./frames";

const Y = new Vector3(0, 1, 0);
const Z = new Vector3(0, 0, 1);
/** Shares of the reach of the picture: an arrow at its limit, and the smallest that can be seen. */
const LONGEST = 0.5;
const SHORTEST = 0.08;
/** Share of the limit: below this there is no arrow. */
const LEAST_SHARE = 0.005;
const BENT = 1.5 * Math.PI;

/** Along +y from 0 to `length`; the head keeps its shape. */
export class StraightArrow {
  readonly group = new Group();
  private readonly shaft: Mesh;
  private readonly head: Mesh;
  private readonly headLength: number;

  constructor(reach: number, material: Material) {
    this.shaft = new Mesh(new CylinderGeometry(0.009 * reach, 0.009 * reach, 1, 12), material);
    this.head = new Mesh(new ConeGeometry(0.026 * reach, 0.06 * reach, 20), material);
    this.headLength = 0.06 * reach;
    this.group.add(this.shaft, this.head);
  }

  resize(length: number): void {
    const shaft = Math.max(length - this.headLength, 1e-9);
    this.shaft.scale.set(1, shaft, 1);
    this.shaft.position.set(0, shaft / 2, 0);
    this.head.position.set(0, shaft + this.headLength / 2, 0);
  }
}

/** About +z, three quarters of a turn. */
class BentArrow {
  readonly group = new Group();
  constructor(reach: number, material: Material) {
    const radius = 0.3 * reach;
    const ring = new Mesh(new TorusGeometry(radius, 0.022 * reach, 10, 48, BENT), material);
    const head = new Mesh(new ConeGeometry(0.07 * reach, 0.14 * reach, 20), material);
    head.position.set(0, -radius, 0); // the arc ends at three quarters of a turn
    head.rotation.z = -Math.PI / 2; // towards +x, the way on
    this.group.add(ring, head);
  }
  resize(length: number, reach: number): void {
    this.group.scale.setScalar(length / (LONGEST * reach));
  }
}

interface Arrow {
  force: DrawnForce;
  holder: Group;
  shape: StraightArrow | BentArrow;
}

export class Arrows {
  readonly group = new Group();
  private readonly arrows: Arrow[];

  /** `reach`: the size of the picture, m. `limits`: per actuator, N or N m. */
  constructor(
    drawing: Drawing,
    private readonly reach: number,
    private readonly limits: readonly number[],
    material: Material,
  ) {
    this.arrows = drawing.forces
      .filter((force) => drawing.bodies[force.body] !== undefined)
      .map((force) => {
        const shape = force.torque
          ? new BentArrow(reach, material)
          : new StraightArrow(reach, material);
        const holder = new Group();
        holder.matrixAutoUpdate = false;
        holder.add(shape.group);
        this.group.add(holder);
        return { force, holder, shape };
      });
  }

  /** `frames` of the bodies, `tau` per actuator. */
  place(frames: Frames, tau: readonly number[]): void {
    for (const { force, holder, shape } of this.arrows) {
      const value = tau[force.actuator] ?? 0;
      const limit = this.limits[force.actuator] ?? 0;
      const share = limit > 0 ? Math.min(Math.abs(value) / limit, 1) : 0;
      const frame = frames[force.body];
      holder.visible = !!frame && share > LEAST_SHARE;
      if (!frame || share <= LEAST_SHARE) continue;
      shape.resize((SHORTEST + (LONGEST - SHORTEST) * share) * this.reach, this.reach);
      const axis = vector(force.axis).multiplyScalar(Math.sign(value)).normalize();
      const turn = new Quaternion().setFromUnitVectors(force.torque ? Z : Y, axis);
      holder.matrix
        .compose(vector(force.point), turn, new Vector3(1, 1, 1))
        .premultiply(frame);
      holder.matrixWorldNeedsUpdate = true;
    }
  }
}
