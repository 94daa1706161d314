/** How a tool follows the device. */

/** A probe that is farther from the tool's aim than `jump*`, m or rad, is not followed at once: the
 * client has just joined, or paused, or the device was moved meanwhile. The tool then comes at
 * `slow*`, m/s and rad/s, from where it was, so that it meets every object from the side that it
 * was on; until it is there, nothing is told (Proxy.free()). The probe may be deep inside an object
 * by then: what is told grows to the whole force within 200 ms. */
export interface Jumps {
  jumpM: number;
  jumpRad: number;
  slowMS: number;
  slowRadS: number;
}

export interface ToolOptions extends Partial<Jumps> {
  /** c > 0: N/m if x is in m, N m/rad if in rad. A force f displaces the proxy by f / c, and the
   * device makes force of displacement: as large as f if c is the stiffness that it displays
   * (w Z_q w^T: 0.15 N m/rad of a finger exoskeleton at 1500 N/m), magnified if c is smaller. */
  coupling: number;
  /** Diagonal of the scene's metric W, one per coordinate, > 0; absent: all 1. With `metric {
   * scale_m scale_rad }` in the scene 1 / scale^2, and `coupling` is in J. A quaternion's four
   * weigh alike: c w / 4 is the stiffness of the rotation, N m/rad. */
  weights?: number[];
  /** Actuators on joints that the device moves stay on, and hold the tool. */
  keepActuators?: boolean;
  /** Hears what a person should know: actuators that are off, and once a second where what is told
   * is not what holds the tool back. Default: console.warn. */
  warn?: (text: string) => void;
}

export const JUMPS: Jumps = { jumpM: 0.03, jumpRad: 0.35, slowMS: 0.5, slowRadS: 6 };
