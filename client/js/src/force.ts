/** Knows if the user wants force, and asks for it in the background: every 50 ms, until the
 * server agrees. Rules as in the C++ client's class of this name. */
import { ClientError } from "./errors.js";
import { EngageWaitSchema } from "./gen/haptic/v1/field_options_pb.js";
import { Event_Kind } from "./gen/haptic/v1/session_pb.js";
import type { Event } from "./gen/haptic/v1/session_pb.js";
import { PREEMPTED, endsLease } from "./reconnection.js";
import { enumName } from "./state_fields.js";

const RETRY_MS = 50;
/** After the server agreed, a state says ENGAGING before this is over. */
const AGREED_MS = 200;
/** A FAULT this soon after want() may be older than the clearFault() that came before it. */
const FAULT_MAY_BE_OLD_MS = 250;
/** Refusals that time and more samples can cure. */
const CURABLE = new Set(EngageWaitSchema.values.map(({ number }) =>
  enumName(EngageWaitSchema, number)));

/** Why an event ends the asking for force; undefined: it does not. `again`: force may come back. */
export function endOfForce(event: Event, leaseEpoch: number,
                           again: boolean): ClientError | undefined {
  const why = (reason: string, text: string): ClientError =>
    new ClientError("failed_precondition", reason, `${text}: ${event.message}`);
  // Clearing a fault, perhaps an emergency stop, must not start a motor.
  if (event.kind === Event_Kind.FAULT) return why(event.reason, "fault");
  if (event.kind === Event_Kind.LOST && !again) return why("LOST", "force was lost");
  if (event.reason === PREEMPTED && endsLease(event, leaseEpoch)) {
    return new ClientError("already_exists", "LEASE_HELD", event.message);
  }
  return undefined;
}

/** The part of the session that it needs. */
export interface ForceOwner {
  /** True if asking makes sense now: there is a stream with a lease, and no force yet. */
  mayAsk(): boolean;
  /** Names the session that asks. */
  id(): string;
  engage(): Promise<unknown>;
}

export class Force {
  /** Why there is no force yet, or why the asking ended. */
  refusal: ClientError | undefined;
  /** A release could not be sent, because there was no stream. */
  releaseOwed = false;
  #wanted = false;
  #askedAt = 0;
  #underWay: Promise<number> | undefined;
  #timer: ReturnType<typeof setTimeout> | undefined;

  /** `again`: ask again whenever force was lost. `nextLease`: and under the lease that follows one
   * that is over. */
  constructor(private readonly owner: ForceOwner, private readonly again: boolean,
              private readonly nextLease: boolean) {}

  want(): void {
    this.#wanted = true;
    this.refusal = undefined;
    this.#askedAt = performance.now();
    this.#askIn(0);
  }

  /** The user gives force up. Resolves when no Engage is under way that a Release could overtake.
   */
  async release(): Promise<void> {
    this.#wanted = false;
    this.refusal = undefined;
    clearTimeout(this.#timer);
    await this.#underWay;
  }

  /** Ends the asking for a reason that waiting must not cure. */
  giveUp(why: ClientError): void {
    if (!this.#wanted) return;
    this.#wanted = false;
    this.refusal = why;
    clearTimeout(this.#timer);
  }

  /** A state says FAULT. */
  faultSeen(): void {
    if (performance.now() - this.#askedAt <= FAULT_MAY_BE_OLD_MS) return;
    this.giveUp(new ClientError("failed_precondition", "FAULT", "the device is in FAULT"));
  }

  #askIn(ms: number): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => void this.#ask(), ms);
  }

  async #ask(): Promise<void> {
    let delay = RETRY_MS;
    if (this.#underWay === undefined && this.owner.mayAsk()) {
      this.#underWay = this.#engage();
      delay = await this.#underWay;
      this.#underWay = undefined;
    }
    if (this.#wanted) this.#askIn(delay);
  }

  /** Resolves to the time until the next look, ms. */
  async #engage(): Promise<number> {
    const id = this.owner.id();
    try {
      await this.owner.engage();
    } catch (error) {
      this.#refused(error as ClientError, id === this.owner.id());
      return RETRY_MS;
    }
    this.refusal = undefined;
    this.#wanted &&= this.again;
    return AGREED_MS;
  }

  #refused(error: ClientError, sameSession: boolean): void {
    if (!this.#wanted) return;
    this.refusal = error;
    const curable = CURABLE.has(error.reason) || error.code === "deadline_exceeded" ||
      error.code === "unavailable";
    // A lease that is over ends nothing: the next session asks again.
    if (sameSession && !curable) this.#wanted = this.nextLease && error.reason === "NOT_CONTROLLER";
  }
}
