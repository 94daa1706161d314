// The bodies of one part of a drawing as capsules of one material.

import type { DrawnCapsule, DrawnPart, Drawing } from "hapticd";
import { CapsuleGeometry, Group, Mesh, Vector3, type Box3, type Material } from "three";
import { vector, type Frames } from "./frames";

const UP = new Vector3(0, 1, 0); // a CapsuleGeometry stands along y

function mesh(capsule: DrawnCapsule, material: Material): Mesh {
  const from = vector(capsule.from);
  const along = vector(capsule.to).sub(from);
  const length = along.length();
  const made = new Mesh(new CapsuleGeometry(capsule.radius, length, 6, 16), material);
  made.position.copy(from).addScaledVector(along, 0.5);
  if (length > 0) made.quaternion.setFromUnitVectors(UP, along.divideScalar(length));
  return made;
}

export class Bodies {
  readonly group = new Group();
  private readonly places: { body: number; group: Group }[] = [];

  constructor(drawing: Drawing, part: DrawnPart, material: Material) {
    drawing.bodies.forEach((body, index) => {
      if (body.part !== part) return;
      const group = new Group();
      group.matrixAutoUpdate = false;
      for (const capsule of body.capsules) group.add(mesh(capsule, material));
      this.group.add(group);
      this.places.push({ body: index, group });
    });
  }

  place(frames: Frames): void {
    for (const { body, group } of this.places) {
      const frame = frames[body];
      group.visible = !!frame;
      if (!frame) continue;
      group.matrix.copy(frame);
      group.matrixWorldNeedsUpdate = true;
    }
  }
}

/** Grows `box` by every capsule of the drawing at these frames. */
export function addBounds(drawing: Drawing, frames: Frames, box: Box3): void {
  const corner = new Vector3();
  drawing.bodies.forEach((body, index) => {
    const frame = frames[index];
    if (!frame) return;
    for (const { from, to, radius } of body.capsules) {
      for (const end of [from, to]) {
        const at = vector(end).applyMatrix4(frame);
        box.expandByPoint(corner.copy(at).addScalar(radius));
        box.expandByPoint(corner.copy(at).addScalar(-radius));
      }
    }
  });
}
