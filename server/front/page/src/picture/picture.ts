// The device, as it stands now: its bodies, where its spring pulls it to, its tool at the probe and
// at the proxy, and the force of each actuator.

import {
  AmbientLight,
  Box3,
  Color,
  DirectionalLight,
  EqualDepth,
  GridHelper,
  MeshLambertMaterial,
  Quaternion,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { Arrows } from "./arrows";
import { addBounds, Bodies } from "./bodies";
import { PART_DEVICE, PART_TOOL, type Drawing } from "./drawing";
import { frames } from "./frames";
import { gridStep, View } from "./view";

/** Part of a state that the picture shows. */
export interface Pose {
  q: readonly number[];
  qStar: readonly number[];
  xProbe: readonly number[];
  x: readonly number[];
  tauA: readonly number[];
}

interface Shown {
  drawing: Drawing;
  device: Bodies;
  ghost: Bodies;
  toolDepth: Bodies;
  tool: Bodies;
  proxy: Bodies;
  arrows: Arrows;
  grid: GridHelper;
}

/** Between two pictures, if the person asked the system for less motion, ms. */
const STILL_MS = 500;

/** A ghost where another body stands gives way to it, so that neither flickers. */
function ghostly(): MeshLambertMaterial {
  return new MeshLambertMaterial({
    transparent: true,
    opacity: 0.45,
    depthWrite: false,
    polygonOffset: true,
    polygonOffsetFactor: 2,
    polygonOffsetUnits: 2,
  });
}

export class Picture {
  readonly view = new View();
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
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
  private asked = false;
  private readonly bounds = new Box3();
  private readonly still = matchMedia("(prefers-reduced-motion: reduce)");

  /** Throws if the browser has no WebGL. */
  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    const sun = new DirectionalLight(0xffffff, 2.2);
    sun.position.set(0.4, 0.8, 1);
    this.view.camera.add(sun); // shines from behind the onlooker
    this.scene.add(this.view.camera, new AmbientLight(0xffffff, 1.1));
    new ResizeObserver(() => this.resize()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.recolour());
    this.recolour();
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
    const { device, ghost, toolDepth, tool, proxy, force } = this.materials;
    this.shown = {
      drawing,
      device: new Bodies(drawing, PART_DEVICE, device),
      ghost: new Bodies(drawing, PART_DEVICE, ghost),
      toolDepth: new Bodies(drawing, PART_TOOL, toolDepth),
      tool: new Bodies(drawing, PART_TOOL, tool),
      proxy: new Bodies(drawing, PART_TOOL, proxy),
      arrows: new Arrows(drawing, reach, limits, force),
      grid: this.grid(box, step),
    };
    const parts = this.parts(this.shown);
    this.scene.add(...parts);
    parts.forEach((part, order) => part.traverse((object) => (object.renderOrder = order)));
    this.recolour();
    this.update(first);
    return step;
  }

  /** Takes the device out of the picture. */
  clear(): void {
    if (!this.shown) return;
    this.scene.remove(...this.parts(this.shown));
    const { device, ghost, toolDepth, tool, proxy, arrows, grid } = this.shown;
    for (const part of [device, ghost, toolDepth, tool, proxy, arrows, grid]) part.dispose();
    this.shown = null;
    this.pose = null;
    this.ask();
  }

  update(pose: Pose): void {
    this.pose = pose;
    this.ask();
  }

  /** Draws before the browser's next frame, once; later if the person wants less motion. */
  ask(): void {
    if (this.asked) return;
    this.asked = true;
    const frame = () =>
      requestAnimationFrame(() => {
        this.asked = false;
        this.draw();
      });
    if (this.still.matches) setTimeout(frame, STILL_MS);
    else frame();
  }

  private draw(): void {
    if (this.shown && this.pose) this.place(this.shown, this.pose);
    this.renderer.render(this.scene, this.view.camera);
  }

  private place(shown: Shown, pose: Pose): void {
    const now = frames(shown.drawing, pose.q, pose.xProbe);
    shown.device.place(now);
    shown.toolDepth.place(now);
    shown.tool.place(now);
    shown.arrows.place(now, pose.tauA);
    addBounds(shown.drawing, now, this.bounds.makeEmpty());
    this.view.include(this.bounds);
    const pulled = pose.qStar.length > 0;
    const led = pose.x.length > 0;
    shown.ghost.group.visible = pulled;
    shown.proxy.group.visible = led;
    if (!pulled && !led) return;
    const wanted = frames(shown.drawing, pulled ? pose.qStar : pose.q, led ? pose.x : pose.xProbe);
    shown.ghost.place(wanted);
    shown.proxy.place(wanted);
  }

  /** In the order in which they are drawn over each other. */
  private parts({ device, ghost, toolDepth, tool, proxy, arrows, grid }: Shown) {
    const bodies = [device, ghost, toolDepth, tool, proxy, arrows];
    return [grid, ...bodies.map(({ group }) => group)];
  }

  /** Behind the device, across the view. */
  private grid(box: Box3, step: number): GridHelper {
    const size = box.getSize(new Vector3());
    const lines = 2 * Math.ceil((0.6 * Math.max(size.x, size.y, size.z)) / step);
    const grid = new GridHelper(lines * step, lines);
    const { normal } = this.view;
    grid.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 1, 0), normal));
    box.getCenter(grid.position);
    const depth = Math.abs(size.dot(normal)) / 2;
    grid.position.addScaledVector(normal, -depth);
    return grid;
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.view.resize(clientWidth, clientHeight);
    this.ask();
  }

  private recolour(): void {
    const style = getComputedStyle(document.documentElement);
    const colour = (name: string) => new Color(style.getPropertyValue(name).trim());
    this.materials.device.color = colour("--body-device");
    this.materials.ghost.color = colour("--body-ghost");
    this.materials.tool.color = colour("--body-tool");
    this.materials.proxy.color = colour("--body-proxy");
    this.materials.force.color = colour("--body-force");
    if (this.shown) {
      const material = this.shown.grid.material;
      material.vertexColors = false;
      material.color = colour("--grid");
      material.needsUpdate = true;
    }
    this.ask();
  }
}
