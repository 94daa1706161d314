// Draws the shapes of a MuJoCo model: the tool where the objects let it be, and pale blue where the
// device is.

import {
  Box3, BoxGeometry, type BufferGeometry, CapsuleGeometry, Color, CylinderGeometry, EdgesGeometry,
  LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PlaneGeometry, SphereGeometry,
  Vector3,
} from "three";
import { colour } from "../dom";
import { StraightArrow } from "../picture/arrows";
import { ghostly, Painter } from "../picture/painter";
import type { Geom, Report } from "./messages";

const PLACE = 12; // numbers of a geom: position, rotation matrix
const PLANE = 0.5; // m, how much of an endless one is drawn
const PER_NEWTON = 0.02, SHORTEST = 0.012, LONGEST = 0.06; // m, of an arrow
const REACH = 0.1; // m, for which arrows are thick enough
const X = new Vector3(1, 0, 0), Y = new Vector3(0, 1, 0), Z = new Vector3(0, 0, 1);
const HELD = 0.0005; // m: a device that is nearer to the tool than this is not drawn
const MOVED = 0.001; // m: a thing that moved less stands still

function shapeOf({ type, size: [x, y, z] }: Geom): BufferGeometry {
  switch (type) {
    case "plane":
      return new PlaneGeometry(2 * Math.min(x || PLANE, PLANE), 2 * Math.min(y || PLANE, PLANE));
    case "sphere": return new SphereGeometry(x, 24, 16);
    case "ellipsoid": return new SphereGeometry(1, 24, 16).scale(x, y, z);
    case "box": return new BoxGeometry(2 * x, 2 * y, 2 * z);
    // Along y here, along z in MuJoCo.
    case "capsule": return new CapsuleGeometry(x, 2 * y, 6, 16).rotateX(Math.PI / 2);
    case "cylinder": return new CylinderGeometry(x, x, 2 * y, 24).rotateX(Math.PI / 2);
  }
}

function put(mesh: Mesh | LineSegments, places: Float32Array, i: number): void {
  const [x, y, z, a, b, c, d, e, f, g, h, k] = places.subarray(PLACE * i, PLACE * (i + 1)) as
    unknown as number[] & { length: 12 };
  mesh.matrix.set(a!, b!, c!, x!, d!, e!, f!, y!, g!, h!, k!, z!, 0, 0, 0, 1);
}

export class Stage {
  private readonly painter: Painter;
  private geoms: Geom[] = [];
  private meshes: Mesh[] = [];
  private ghosts: (Mesh | null)[] = [];
  private points: Mesh[] = [];
  private arrows: StraightArrow[] = [];
  /** Outlines of things that can be pushed away: as they stood first. */
  private outlines: { name: string; i: number; line: LineSegments; from?: Vector3 }[] = [];
  /** Behind the tool where both are at one place. */
  private readonly ghost = ghostly();
  /** Material of arrows: in sight, whatever is in front. */
  private readonly ink = new MeshLambertMaterial({ depthTest: false, transparent: true });
  private readonly up = new Vector3();
  private fitted = false;

  /** Throws if the browser has no WebGL. */
  constructor(canvas: HTMLCanvasElement) {
    this.painter = new Painter(canvas, true, { theme: () => this.recolour() });
    this.painter.theme();
  }

  /** Pictures painted since the beginning. */
  get painted(): number {
    return this.painter.painted;
  }

  show(geoms: Geom[], up: [number, number, number]): void {
    this.geoms = geoms;
    this.painter.clear();
    this.up.set(...up);
    this.fitted = false;
    this.points = [];
    this.arrows = [];
    this.outlines = [];
    const add = (geom: Geom, material: MeshLambertMaterial): Mesh => {
      const mesh = new Mesh(shapeOf(geom), material);
      mesh.matrixAutoUpdate = false;
      this.painter.world.add(mesh);
      return mesh;
    };
    this.meshes = geoms.map((geom) => add(geom, new MeshLambertMaterial({
      color: new Color(...geom.rgba.slice(0, 3) as [number, number, number]),
      transparent: geom.rgba[3] < 1, opacity: geom.rgba[3],
    })));
    this.ghosts = geoms.map((geom) => (geom.tool ? add(geom, this.ghost) : null));
    const ink = new LineBasicMaterial({ color: colour("--soft") });
    geoms.forEach((geom, i) => {
      if (!geom.free) return;
      const line = new LineSegments(new EdgesGeometry(shapeOf(geom), 30), ink);
      line.matrixAutoUpdate = false;
      this.painter.world.add(line);
      this.outlines.push({ name: geom.free, i, line });
    });
  }

  place({ places, probe, points }: Extract<Report, { kind: "frame" }>): void {
    this.meshes.forEach((mesh, i) => put(mesh, places, i));
    for (const outline of this.outlines) {
      if (outline.from) continue;
      put(outline.line, places, outline.i);
      outline.from = new Vector3().setFromMatrixPosition(outline.line.matrix);
    }
    const held = probe.length > 0 && this.ghosts.some((ghost, i) => ghost && [0, 1, 2].some(
      (k) => Math.abs(probe[PLACE * i + k]! - places[PLACE * i + k]!) > HELD));
    this.ghosts.forEach((mesh, i) => {
      if (!mesh) return;
      mesh.visible = held;
      if (held) put(mesh, probe, i);
    });
    for (let i = 0; 3 * i < points.length; ++i) {
      const point = this.points[i] ??= new Mesh(new SphereGeometry(0.004, 12, 8), this.ghost);
      if (!point.parent) this.painter.world.add(point);
      point.position.fromArray(points, 3 * i);
    }
    if (!this.fitted) this.fit();
    this.painter.ask();
  }

  /** Things that are not where they stood first. */
  pushed(): { name: string; mm: number }[] {
    const most = new Map<string, number>();
    for (const { name, i, from } of this.outlines) {
      const at = new Vector3().setFromMatrixPosition(this.meshes[i]!.matrix);
      most.set(name, Math.max(most.get(name) ?? 0, from ? at.distanceTo(from) : 0));
    }
    return [...most].filter(([, way]) => way > MOVED)
      .map(([name, way]) => ({ name, mm: Math.round(1000 * way) }));
  }

  /** An arrow for each, and no other. */
  press(presses: Float32Array): void {
    this.painter.ask();
    for (let i = 0; i < Math.max(presses.length / 6, this.arrows.length); ++i) {
      const arrow = this.arrows[i] ??= new StraightArrow(REACH, this.ink), { group } = arrow;
      if (!group.parent) this.painter.world.add(group);
      const force = new Vector3().fromArray(presses, 6 * i + 3);
      group.visible = 6 * i < presses.length;
      if (!group.visible) continue;
      group.position.fromArray(presses, 6 * i);
      arrow.resize(Math.min(Math.max(PER_NEWTON * force.length(), SHORTEST), LONGEST));
      group.quaternion.setFromUnitVectors(Y, force.normalize());
    }
  }

  /** Looks at all but planes, a little from above. */
  private fit(): void {
    this.fitted = true;
    const box = new Box3();
    this.meshes.forEach((mesh, i) => {
      if (this.geoms[i]!.type === "plane") return;
      mesh.geometry.computeBoundingBox();
      box.union(mesh.geometry.boundingBox!.clone().applyMatrix4(mesh.matrix));
    });
    this.painter.view.look(box, this.up.z > 0.5 ? X : Z, this.up);
  }

  private recolour(): void {
    this.painter.scene.background = new Color(colour("--back"));
    this.ghost.color.set(colour("--body-ghost"));
    this.ink.color.set(colour("--body-force"));
  }
}
