// A canvas in which three.js paints a world: when it is asked to, as large as the page shows it,
// and in the colours of the page's theme.

import {
  AmbientLight, DirectionalLight, Group, LineSegments, Mesh, MeshLambertMaterial, Scene,
  WebGLRenderer,
} from "three";
import { View } from "./view";

/** A ghost where another body stands gives way to it, so that neither flickers. */
export const ghostly = (): MeshLambertMaterial => new MeshLambertMaterial({
  transparent: true,
  opacity: 0.45,
  depthWrite: false,
  polygonOffset: true,
  polygonOffsetFactor: 2,
  polygonOffsetUnits: 2,
});

/** `theme` is called when the page's colours change, `resize` when the canvas has another size,
 * `paint` before each picture. */
interface Hooks {
  theme(): void;
  resize?(): void;
  paint?(): void;
}

export class Painter {
  readonly scene = new Scene();
  readonly world = new Group();
  readonly view: View;
  /** Pictures painted since the beginning. */
  painted = 0;
  private readonly renderer: WebGLRenderer;
  private asked = false;

  /** `moves`: see View. Throws if the browser has no WebGL. */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    moves: boolean,
    private readonly hooks: Hooks,
  ) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    const sun = new DirectionalLight(0xffffff, 2.2);
    sun.position.set(0.4, 0.8, 1);
    this.view = new View(canvas, this.world, moves, () => this.ask());
    this.view.camera.add(sun); // shines from behind the onlooker
    this.scene.add(this.view.camera, new AmbientLight(0xffffff, 1.1), this.world);
    new ResizeObserver(() => this.resize()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.theme());
  }

  theme(): void {
    this.hooks.theme();
    this.ask();
  }

  /** Empties the world. */
  clear(): void {
    this.world.traverse((object) => {
      if (object instanceof Mesh || object instanceof LineSegments) object.geometry.dispose();
    });
    this.world.clear();
    this.ask();
  }

  /** Paints before the browser's next frame, once; after `ms` at the earliest. */
  ask(ms = 0): void {
    if (this.asked) return;
    this.asked = true;
    const frame = () =>
      requestAnimationFrame(() => {
        this.asked = false;
        this.hooks.paint?.();
        this.renderer.render(this.scene, this.view.camera);
        this.painted++;
      });
    if (ms > 0) setTimeout(frame, ms);
    else frame();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.view.camera.aspect = clientWidth / clientHeight;
    this.view.camera.updateProjectionMatrix();
    this.hooks.resize?.();
    this.ask();
  }
}
