// From where the device is looked at: onto its widest side, a little from above, and turned by
// hand.

import { Box3, PerspectiveCamera, Spherical, Vector3 } from "three";

const TILT = 0.35; // rad, so that depth can be seen
const ASIDE = 0.4;
const STEP = Math.PI / 12;
const FAR_UP = 0.05; // rad that is left to the pole
const AIR = 1.08;

/** A step of the grid that gives about eight lines: 1, 2 or 5 times a power of ten, m. */
export function gridStep(size: number): number {
  const wish = size / 8;
  const power = 10 ** Math.floor(Math.log10(wish));
  return [1, 2, 5, 10].map((n) => n * power).find((step) => step >= wish) ?? 10 * power;
}

function corners({ min, max }: Box3): Vector3[] {
  return Array.from(
    { length: 8 },
    (_, i) => new Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z),
  );
}

export class View {
  readonly camera = new PerspectiveCamera(32, 1, 0.001, 100);
  /** Across the widest side of the device: a flat device lies in the picture's plane. */
  readonly normal = new Vector3(0, 0, 1);
  private readonly up = new Vector3(0, 1, 0);
  private readonly box = new Box3();
  private readonly target = new Vector3();
  private azimuth = ASIDE;
  private elevation = TILT;
  private distance = 1;
  private zoom = 1;

  /** Chooses the side for `box`, and looks at all of it. */
  fit(box: Box3): void {
    const size = box.getSize(new Vector3());
    if (size.z <= size.x && size.z <= size.y) {
      this.normal.set(0, 0, 1);
      this.up.set(0, 1, 0);
    } else {
      if (size.y <= size.x) this.normal.set(0, -1, 0);
      else this.normal.set(1, 0, 0);
      this.up.set(0, 0, 1);
    }
    this.box.copy(box);
    this.reset();
  }

  /** Moves away until `box` is seen too; the direction stays. */
  include(box: Box3): void {
    if (this.box.containsBox(box)) return;
    this.box.union(box);
    this.measure();
  }

  reset(): void {
    this.azimuth = ASIDE;
    this.elevation = TILT;
    this.zoom = 1;
    this.measure();
  }

  turn(right: number, up: number): void {
    this.azimuth += right;
    const most = Math.PI / 2 - FAR_UP;
    this.elevation = Math.min(Math.max(this.elevation + up, -most), most);
    this.place();
  }

  turnStep(right: number, up: number): void {
    this.turn(right * STEP, up * STEP);
  }

  magnify(factor: number): void {
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.3), 8);
    this.place();
  }

  /** Moves the camera so far away that it sees all corners of the box. */
  measure(): void {
    if (this.box.isEmpty()) return;
    this.box.getCenter(this.target);
    const away = this.away();
    const right = new Vector3().crossVectors(this.up, away).normalize();
    const above = new Vector3().crossVectors(away, right);
    const high = Math.tan((this.camera.fov / 360) * Math.PI);
    const wide = high * this.camera.aspect;
    this.distance = 0;
    for (const corner of corners(this.box)) {
      corner.sub(this.target);
      const across = Math.max(
        Math.abs(corner.dot(right)) / wide,
        Math.abs(corner.dot(above)) / high,
      );
      this.distance = Math.max(this.distance, corner.dot(away) + AIR * across);
    }
    this.place();
  }

  /** From the target to the camera. Spherical counts from y, and its azimuth from z. */
  private away(): Vector3 {
    const way = new Vector3().setFromSpherical(
      new Spherical(1, Math.PI / 2 - this.elevation, this.azimuth),
    );
    return new Vector3()
      .crossVectors(this.up, this.normal)
      .multiplyScalar(way.x)
      .addScaledVector(this.up, way.y)
      .addScaledVector(this.normal, way.z);
  }

  private place(): void {
    const { camera } = this;
    const distance = this.distance / this.zoom;
    camera.position.copy(this.target).addScaledVector(this.away(), distance);
    camera.up.copy(this.up);
    camera.lookAt(this.target);
    camera.near = distance / 100;
    camera.far = distance * 20;
    camera.updateProjectionMatrix();
  }
}
