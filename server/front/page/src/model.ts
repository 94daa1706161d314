// Parts of the server's messages that the page reads. The messages of the client library fit these
// types as they are; 64-bit integers are bigints, enums are their numbers.

import type { Drawing } from "./picture/drawing";

export interface DegreeOfFreedom {
  name: string;
  unit: string; // "m", "rad"
  actuated: boolean;
  lower: number;
  upper: number;
  maxEffort: number;
}

export interface Device {
  name: string;
  kind: string;
  model: string;
  moves: boolean;
  dofs: DegreeOfFreedom[];
  coordinates: { name: string; unit: string }[];
  forceLimit: number[];
  stiffnessLimit: number[];
  controller: string;
  tracker: string;
  wantsTracker: boolean;
  calibrated: string;
  unguarded: string[];
  drawing?: Drawing | undefined;
}

export interface DeviceState {
  seq: bigint;
  serverTimeNs: bigint;
  state: number;
  mode: number;
  proxySeqUsed: bigint;
  proxyAgeUs: bigint;
  staleness: number;
  gain: number;
  transport: number;
  q: number[];
  xProbe: number[];
  x: number[];
  qStar: number[];
  tauA: number[];
  tauElastic: number[];
  errorBound: number[];
  stiffnessInEffect: number[];
  derating: number;
  deratingDelayUs: bigint;
  activePlanes: number;
  faults: number;
  limiters: number;
  passivity?: { tank: number } | undefined;
}

export interface PageEvent {
  kind: number;
  serverTimeNs: bigint;
  reason: string;
  message: string;
}

export interface Duration {
  seconds: bigint;
  nanos: number;
}

export interface LinkDirection {
  lost: bigint;
  rejected: { reason: string; count: bigint }[];
}

export interface SessionLink {
  device: string;
  clientName: string;
  role: number;
  holdsLease: boolean;
  samplesBy: number;
  statesBy: number;
  transports: {
    transport: number;
    up?: LinkDirection | undefined;
    down?: LinkDirection | undefined;
    roundTrip?: Duration | undefined;
  }[];
  ageP50?: Duration | undefined;
  ageP99?: Duration | undefined;
}

export interface ServerInfo {
  version: string;
  scene: string;
  realtime?: { grade: string; explanation: string } | undefined;
  loop?:
    | {
        skipped: bigint;
        latenessP50Us: number;
        latenessP99Us: number;
        latenessMaxUs: number;
        tickP99Us: number;
      }
    | undefined;
  insecure: string[];
  maxSessions: number;
  sessions: number;
  uptime?: Duration | undefined;
}

/** Numbers of DeviceState.state. */
export const enum Lifecycle {
  INIT = 1,
  IDLE,
  ARMED,
  ENGAGING,
  ENGAGED,
  RELEASING,
  FAULT,
  CLOSING,
}

/** Numbers of DeviceState.mode. */
export const enum Mode {
  HELD = 1,
  FREE,
  PLANES,
}

/** Numbers of Event.kind: the device's state changed; the level of the proxy's age changed. */
export const KIND_STATE = 1;
export const KIND_STALENESS = 6;
