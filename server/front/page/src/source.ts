// The page's door to the server: what it asks and hears. live_source.ts is the real one.

import type { Device, DeviceState, PageEvent, ServerInfo, SessionLink } from "./model";

/** A refused call: the canonical code ("permission_denied"), the server's stable reason, words. */
export class SourceError extends Error {
  constructor(
    readonly code: string,
    readonly reason: string,
    message: string,
  ) {
    super(message);
  }
}

export interface Listener {
  state(state: DeviceState): void;
  event(event: PageEvent): void;
  /** The stream ended; it does not come back by itself. */
  ended(error: SourceError): void;
}

/** A stream of states; ends when it is closed. */
export interface Watching {
  close(): void;
}

export interface Source {
  /** Names of bit 0, 1, ... of DeviceState.faults and .limiters; "-" is never set. */
  readonly faultNames: readonly string[];
  readonly limiterNames: readonly string[];

  devices(): Promise<Device[]>;
  serverInfo(): Promise<ServerInfo>;
  links(): Promise<SessionLink[]>;
  watch(device: string, listener: Listener): Watching;

  /** True if this page's key allows more than to look and to stop. */
  mayControl(device: string): Promise<boolean>;
  /** All devices; answers with the names of those that are stopped. */
  stop(): Promise<string[]>;
  clearFaults(device: string): Promise<void>;
  /** Takes the device from a program of lower priority, so that its force fades out; and leaves. */
  release(device: string): Promise<void>;
}
