/** The newest state of a session, which state the user was last given, and who waits for one. */
import { transport } from "#transport";
import type { ClientError } from "./errors.js";
import { localError } from "./errors.js";
import type { DeviceState } from "./gen/haptic/v1/session_pb.js";

/** The state that the user computes the next sample from. */
export interface Given {
  seq: bigint;
  receivedMs: number;
  xProbe: number[];
}

interface Waiter {
  after: bigint;  // what wait() had given when this one began
  resolve(state: DeviceState): void;
  reject(why: ClientError): void;
}

export class NewestState {
  newest: DeviceState | undefined;
  given: Given | undefined;
  #receivedMs = 0;
  #returned = 0n;  // by wait()
  #waiters = new Set<Waiter>();
  #waking = false;

  /** False if a newer one is known. */
  take(state: DeviceState, nowMs: number): boolean {
    if (this.newest !== undefined && state.seq <= this.newest.seq) return false;
    this.newest = state;
    this.#receivedMs = nowMs;
    if (this.#waiters.size > 0 && !this.#waking) {
      this.#waking = true;
      // Who is slower than states come would else compute with older and older ones.
      transport.afterMessages(() => this.#wake());
    }
    return true;
  }

  /** Another session begins; its server may count ticks from the beginning. */
  restart(): void {
    this.newest = this.given = undefined;
    this.#returned = 0n;
    for (const waiter of this.#waiters) waiter.after = 0n;
  }

  /** For the user, who computes the next sample from it. */
  give(): DeviceState | undefined {
    if (this.newest === undefined) return undefined;
    const { seq, xProbe } = this.newest;
    this.given = { seq, xProbe, receivedMs: this.#receivedMs };
    return this.newest;
  }

  /** A state newer than the last that wait() had given when it was called. */
  wait(timeoutMs: number): Promise<DeviceState> {
    if (this.newest !== undefined && this.newest.seq > this.#returned) {
      return Promise.resolve(this.#return(this.newest));
    }
    return new Promise((resolve, reject) => {
      const end = (): void => {
        clearTimeout(timer);
        this.#waiters.delete(waiter);
      };
      const waiter: Waiter = {
        after: this.#returned,
        resolve: (state) => (end(), resolve(state)),
        reject: (why) => (end(), reject(why)),
      };
      const timer = setTimeout(() => waiter.reject(
        localError("deadline_exceeded", `no state in ${timeoutMs} ms`)), timeoutMs);
      this.#waiters.add(waiter);
    });
  }

  /** No state comes any more. */
  end(why: ClientError): void {
    for (const { reject } of this.#waiters) reject(why);
  }

  #wake(): void {
    this.#waking = false;
    const { newest } = this;
    if (newest === undefined) return;
    for (const { after, resolve } of this.#waiters) {
      if (newest.seq > after) resolve(this.#return(newest));
    }
  }

  #return(state: DeviceState): DeviceState {
    this.#returned = state.seq;
    this.give();
    return state;
  }
}
