/** Knows if a session has a stream, and when the next attempt at one is due. Like the C++ client's
 * class of this name it reads no clock and opens no stream. */
import { ClientError, mayPass } from "./errors.js";
import { Event_Kind } from "./gen/haptic/v1/session_pb.js";
import type { Event } from "./gen/haptic/v1/session_pb.js";

const FIRST_DELAY_MS = 100, LONGEST_DELAY_MS = 500;

/** over: no stream, and no attempt follows. leaseLost: there is a stream, but the session only
 * observes. waiting: the next attempt is due. closed: by the user. */
type State = "over" | "opening" | "open" | "leaseLost" | "waiting" | "closed";

export const PREEMPTED = "LEASE_PREEMPTED";

/** True if the event ends the lease of this number. The end of an earlier session's lease may still
 * be told to a session that opens just then. */
export function endsLease(event: Event, leaseEpoch: number): boolean {
  return event.leaseEpoch === leaseEpoch &&
    (event.kind === Event_Kind.LEASE_EXPIRED || event.reason === PREEMPTED);
}

export class Reconnection {
  state: State = "over";
  /** Why the last stream ended. */
  why: ClientError = new ClientError("ok", "CLOSED", "the session ended");
  #delay = 0;
  #begunMs = -Infinity;

  /** `wanted`: whether the session takes up a lost stream again. */
  constructor(private readonly wanted: boolean) {}

  get open(): boolean {
    return this.state === "open" || this.state === "leaseLost";
  }
  get over(): boolean {
    return this.state === "over" || this.state === "closed";
  }

  begin(nowMs: number): void {
    this.state = "opening";
    this.#begunMs = nowMs;
  }

  opened(): void {
    this.state = "open";
    this.#delay = 0;
  }

  /** Only a new session controls the device. */
  leaseLost(): void {
    if (this.state === "open") this.state = "leaseLost";
  }

  /** The stream ended, or the opening failed. Returns the time to the next attempt in ms: 0, then
   * 100, 200, 400, 500, 500 ..., and 100 at least after the last began, for a server that opens
   * every session and ends it; undefined: none follows. */
  ended(why: ClientError, nowMs: number): number | undefined {
    this.why = why;
    const delay = this.#delay;
    if (!this.wanted || (delay > 0 && !mayPass(why))) {
      this.state = "over";
      return undefined;
    }
    this.state = "waiting";
    this.#delay = delay === 0 ? FIRST_DELAY_MS : Math.min(2 * delay, LONGEST_DELAY_MS);
    return Math.max(delay, FIRST_DELAY_MS - (nowMs - this.#begunMs));
  }
}
