// The device, as it stands now: its bodies, where its spring pulls it to, its tool at the probe and
// at the proxy, and the force of each actuator.

import { DrawnPart, type DeviceState, type Drawing } from "hapticd";
import { Box3, EqualDepth, GridHelper, MeshLambertMaterial, Vector3 } from "three";
import { colour } from "../dom";
import { Arrows } from "./arrows";
import { addBounds, Bodies } from "./bodies";
import { frames } from "./frames";
import { ghostly, Painter } from "./painter";
import { gridStep, type View } from "./view";

/** Part of a state that the picture shows. */
type Pose = Pick<DeviceState, "q" | "qStar" | "xProbe" | "x" | "tauA">;

/** Layers of bodies, in the order in which they are drawn over each other. */
const LAYERS = ["device", "ghost", "toolDepth", "tool", "proxy"] as const;
type Layer = (typeof LAYERS)[number];

interface Shown {
  drawing: Drawing;
  bodies: Record<Layer, Bodies>;
  arrows: Arrows;
  grid: GridHelper;
}

/** Between two pictures, if the person asked the system for less motion, ms. */
const STILL_MS = 500;

export class Picture {
  private readonly painter: Painter;
  private readonly materials = {
    device: new MeshLambertMaterial(),
    ghost: ghostly(),
    // A finger is a tool, and hides the links on it: they shine through its nearest surface, which
    // is found first, so that two bodies that meet in a joint are not blended twice.
    toolDepth: new MeshLambertMaterial({ transparent: true, colorWrite: false }),
    tool: new MeshLambertMaterial({ transparent: true, opacity: 0.62, depthFunc: EqualDepth }),
    proxy: ghostly(),
    force: new MeshLambertMaterial({ transparent: true, depthTest: false }), // over everything
  };
  private shown: Shown | null = null;
  private pose: Pose | null = null;
  private readonly bounds = new Box3();
  private readonly still = matchMedia("(prefers-reduced-motion: reduce)");

  /** Throws if the browser has no WebGL. */
  constructor(canvas: HTMLCanvasElement) {
    this.painter = new Painter(canvas, false, {
      theme: () => this.recolour(),
      resize: () => this.view.measure(),
      paint: () => this.shown && this.pose && this.place(this.shown, this.pose),
    });
    this.painter.theme();
  }

  get view(): View {
    return this.painter.view;
  }

  /** `limits`: per actuator, N or N m; `first`: the pose that the view is made for. Answers with
   * the step of the grid, m. */
  show(drawing: Drawing, limits: readonly number[], first: Pose): number {
    this.clear();
    const box = new Box3();
    addBounds(drawing, frames(drawing, first.q, first.xProbe), box);
    if (box.isEmpty()) return 0;
    const size = box.getSize(new Vector3());
    const reach = size.length();
    const step = gridStep(Math.max(size.x, size.y, size.z));
    this.view.fit(box.expandByVector(size.multiplyScalar(0.1))); // it will move
    const made = (layer: Layer) => {
      const isDevice = layer === "device" || layer === "ghost";
      const part = isDevice ? DrawnPart.DEVICE : DrawnPart.TOOL;
      return [layer, new Bodies(drawing, part, this.materials[layer])] as const;
    };
    const bodies = Object.fromEntries(LAYERS.map(made)) as Record<Layer, Bodies>;
    const arrows = new Arrows(drawing, reach, limits, this.materials.force);
    const grid = this.grid(box, step);
    this.shown = { drawing, bodies, arrows, grid };
    const parts = [grid, ...LAYERS.map((layer) => bodies[layer].group), arrows.group];
    this.painter.world.add(...parts);
    parts.forEach((part, order) => part.traverse((object) => (object.renderOrder = order)));
    this.painter.theme();
    this.update(first);
    return step;
  }

  /** Takes the device out of the picture. */
  clear(): void {
    this.shown = null;
    this.pose = null;
    this.painter.clear();
  }

  update(pose: Pose): void {
    this.pose = pose;
    this.ask();
  }

  /** Draws soon; later if the person wants less motion. */
  ask(): void {
    this.painter.ask(this.still.matches ? STILL_MS : 0);
  }

  private place({ drawing, bodies, arrows }: Shown, pose: Pose): void {
    const now = frames(drawing, pose.q, pose.xProbe);
    for (const layer of ["device", "toolDepth", "tool"] as const) bodies[layer].place(now);
    arrows.place(now, pose.tauA);
    addBounds(drawing, now, this.bounds.makeEmpty());
    this.view.include(this.bounds);
    const pulled = pose.qStar.length > 0;
    const led = pose.x.length > 0;
    bodies.ghost.group.visible = pulled;
    bodies.proxy.group.visible = led;
    if (!pulled && !led) return;
    const wanted = frames(drawing, pulled ? pose.qStar : pose.q, led ? pose.x : pose.xProbe);
    bodies.ghost.place(wanted);
    bodies.proxy.place(wanted);
  }

  /** Behind the device, across the view. */
  private grid(box: Box3, step: number): GridHelper {
    const size = box.getSize(new Vector3());
    const lines = 2 * Math.ceil((0.6 * Math.max(size.x, size.y, size.z)) / step);
    const grid = new GridHelper(lines * step, lines);
    const { normal } = this.view;
    grid.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), normal);
    box.getCenter(grid.position);
    const depth = Math.abs(size.dot(normal)) / 2;
    grid.position.addScaledVector(normal, -depth);
    return grid;
  }

  private recolour(): void {
    for (const name of ["device", "ghost", "tool", "proxy", "force"] as const) {
      this.materials[name].color.set(colour(`--body-${name}`));
    }
    if (!this.shown) return;
    const { material } = this.shown.grid;
    material.vertexColors = false;
    material.color.set(colour("--grid"));
    material.needsUpdate = true;
  }
}
