/** Whether a session has a stream, and when the next attempt at one is due. As the C++ client's
 * class of this name; it reads no clock and opens no stream. */
import { ClientError, mayPass } from "./errors.js";

const FIRST_DELAY_MS = 100, LONGEST_DELAY_MS = 500;

/** over: no stream, and no attempt follows. leaseLost: there is a stream, but the session only
 * observes. waiting: the next attempt is due. closed: by the user. */
type State = "over" | "opening" | "open" | "leaseLost" | "waiting" | "closed";

export class Reconnection {
  state: State = "over";
  /** Why the last stream ended. */
  why: ClientError = new ClientError("ok", "CLOSED", "the session ended");
  #delay = 0;

  /** `wanted`: whether the session takes up a lost stream again. */
  constructor(private readonly wanted: boolean) {}

  get open(): boolean {
    return this.state === "open" || this.state === "leaseLost";
  }
  get over(): boolean {
    return this.state === "over" || this.state === "closed";
  }

  opened(): void {
    this.state = "open";
    this.#delay = 0;
  }

  /** The stream ended, or the opening failed. Returns the time to the next attempt in ms: 0, then
   * 100, 200, 400, 500, 500 ...; undefined: none follows. */
  ended(why: ClientError): number | undefined {
    this.why = why;
    const delay = this.#delay;
    if (!this.wanted || (delay > 0 && !mayPass(why))) {
      this.state = "over";
      return undefined;
    }
    this.state = "waiting";
    this.#delay = delay === 0 ? FIRST_DELAY_MS : Math.min(2 * delay, LONGEST_DELAY_MS);
    return delay;
  }
}
