// From where a world is looked at: onto its widest side, a little from above, and turned by hand.

import { Box3, type Group, Matrix4, PerspectiveCamera, Spherical, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const X = new Vector3(1, 0, 0);
const Y = new Vector3(0, 1, 0);
const Z = new Vector3(0, 0, 1);
const TILT = 0.35; // rad, so that depth can be seen
const ASIDE = 0.4;
const STEP = Math.PI / 12;
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

/** A mouse turns the world both ways; a finger from side to side, and scrolls the page up and
 * down. */
export class View {
  readonly camera = new PerspectiveCamera(32, 1, 0.001, 100);
  /** The side of the world that is looked at. */
  readonly normal = new Vector3();
  private readonly controls: OrbitControls;
  private readonly box = new Box3();

  /** `changed`: another picture is needed. `moves`: the wheel and other buttons move the camera. */
  constructor(
    canvas: HTMLCanvasElement,
    private readonly world: Group,
    moves: boolean,
    changed: () => void,
  ) {
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableZoom = this.controls.enablePan = moves;
    this.controls.addEventListener("change", changed);
    canvas.style.touchAction = ""; // as the style sheet says
  }

  /** Looks at all of `box`, across its widest side: a flat device lies in the picture's plane. */
  fit(box: Box3): void {
    const { x, y, z } = box.getSize(new Vector3());
    if (z <= x && z <= y) this.look(box, Z, Y);
    else this.look(box, y <= x ? Y.clone().negate() : X, Z);
  }

  /** Looks at all of `box` from the side of `normal`. */
  look(box: Box3, normal: Vector3, up: Vector3): void {
    const above = up.clone().normalize();
    const right = new Vector3().crossVectors(above, normal).normalize();
    this.normal.crossVectors(right, above);
    const turned = new Matrix4().makeBasis(right, above, this.normal).transpose();
    this.world.quaternion.setFromRotationMatrix(turned);
    this.world.updateMatrix();
    this.box.copy(box).applyMatrix4(this.world.matrix);
    this.reset();
  }

  /** Moves away until `box` is seen too; the direction stays. */
  include(box: Box3): void {
    const seen = box.clone().applyMatrix4(this.world.matrix);
    if (this.box.containsBox(seen)) return;
    this.box.union(seen);
    this.measure();
  }

  reset(): void {
    const { target } = this.controls;
    this.camera.zoom = 1;
    this.camera.position.setFromSphericalCoords(1, Math.PI / 2 - TILT, ASIDE).add(target);
    this.measure();
  }

  turnStep(right: number, up: number): void {
    const { camera, controls } = this;
    const way = new Spherical().setFromVector3(camera.position.clone().sub(controls.target));
    way.theta += right * STEP;
    way.phi -= up * STEP;
    camera.position.setFromSpherical(way.makeSafe()).add(controls.target);
    controls.update();
  }

  magnify(factor: number): void {
    this.camera.zoom = Math.min(Math.max(this.camera.zoom * factor, 0.3), 8);
    this.camera.updateProjectionMatrix();
  }

  /** Moves the camera so far away that it sees all corners of the box. */
  measure(): void {
    if (this.box.isEmpty()) return;
    const { camera, controls } = this;
    const away = camera.position.clone().sub(controls.target).normalize();
    const right = new Vector3().crossVectors(Y, away).normalize();
    const above = new Vector3().crossVectors(away, right);
    const high = Math.tan((camera.fov / 360) * Math.PI);
    const wide = high * camera.aspect;
    this.box.getCenter(controls.target);
    let distance = 0;
    for (const corner of corners(this.box)) {
      corner.sub(controls.target);
      const across = Math.max(
        Math.abs(corner.dot(right)) / wide,
        Math.abs(corner.dot(above)) / high,
      );
      distance = Math.max(distance, corner.dot(away) + AIR * across);
    }
    camera.position.copy(controls.target).addScaledVector(away, distance);
    camera.near = distance / 100;
    camera.far = distance * 20;
    camera.updateProjectionMatrix();
    controls.update();
  }
}
