// Messages between the page and its worker.

import type { DeviceStateName } from "hapticd";

/** Message of the page. */
export type Order =
  | { kind: "start"; scene: string; token?: string }
  | { kind: "engage" | "release" | "reset" }
  /** The last frame was shown: send the next. So none waits for a slow page. */
  | { kind: "shown" };

/** A shape of the model. `size` as MuJoCo's. */
export interface Geom {
  type: "plane" | "sphere" | "capsule" | "ellipsoid" | "cylinder" | "box";
  size: [number, number, number];
  rgba: [number, number, number, number];
  /** Part of what the device moves. */
  tool: boolean;
  /** Name of its body, if nothing holds that; empty: it cannot be pushed away. */
  free: string;
}

export interface Motor {
  name: string;
  unit: string;
}

/** How long a frame's physics and publishing took, ms, of the newest 600. */
export interface Timing {
  median: number;
  p99: number;
  frames: number;
}

/** Message of the worker. */
export type Report =
  | { kind: "scene"; device: string; geoms: Geom[]; up: [number, number, number]; motors: Motor[] }
  | {
      kind: "frame";
      /** Per geom position and rotation matrix, row by row: 12 numbers. */
      places: Float32Array;
      /** The same of the tool's geoms where the device is; empty: not known. */
      probe: Float32Array;
      /** Where the device is, as points in the world, 3 numbers each. */
      points: Float32Array;
      /** Per contact that presses: where, and the force on the tool, N: 6 numbers. */
      presses: Float32Array;
      /** Name of what presses; empty: it has none. */
      touched: string[];
      state: DeviceStateName;
      /** Why there is no force, although it was asked for; empty: there is, or it was not. */
      refusal: string;
      forces: number[];
      following: boolean;
      timing: Timing;
    }
  | { kind: "said"; text: string; reason: string };
