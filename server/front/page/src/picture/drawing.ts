// The drawing of a device as the page reads it: haptic.v1.Drawing. A message of the client library
// fits it as it is.

export const PART_DEVICE = 1;
export const PART_TOOL = 2;

export const VALUE_Q = 1;
export const VALUE_X = 2;

export const KIND_ROTATION = 1;
export const KIND_TRANSLATION = 2;
export const KIND_ORIENTATION = 3;
export const KIND_ROTATION_VECTOR = 4;
export const KIND_AIM = 5;

export interface DrawnMotion {
  kind: number;
  axis: readonly number[];
  value: number;
  index: number;
  factor: number;
  offset: number;
  target: number;
  targetPoint: readonly number[];
}

export interface DrawnCapsule {
  from: readonly number[];
  to: readonly number[];
  radius: number;
}

export interface DrawnBody {
  name: string;
  part: number;
  parent: number;
  position: readonly number[];
  orientation: readonly number[];
  motions: readonly DrawnMotion[];
  capsules: readonly DrawnCapsule[];
}

export interface DrawnForce {
  actuator: number;
  body: number;
  point: readonly number[];
  axis: readonly number[];
  torque: boolean;
}

export interface Drawing {
  bodies: readonly DrawnBody[];
  forces: readonly DrawnForce[];
}
