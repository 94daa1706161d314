// Clear fault and Release force, and why they are not possible.

import { at, say } from "../dom";
import { Lifecycle, type Device, type DeviceState } from "../model";
import { SourceError, type Source } from "../source";

const ASKING = "Asking what this page may do …";
const ONLY_LOOKS = "This page's key allows looking and stopping only.";

/** A button with the sentence below it. */
class Action {
  private readonly button: HTMLButtonElement;
  private readonly why: HTMLElement;
  constructor(id: string, act: () => Promise<void>) {
    this.button = at<HTMLButtonElement>(id);
    this.why = at(`${id}-why`);
    this.button.addEventListener("click", () => void act());
  }
  set(possible: boolean, why: string): void {
    if (this.button.disabled === possible) this.button.disabled = !possible;
    say(this.why, why);
  }
}

export class Actions {
  private readonly said = at("action-said");
  private readonly clear: Action;
  private readonly release: Action;
  private device = "";
  private mayControl: boolean | null = null;

  constructor(private readonly source: () => Source) {
    this.clear = new Action("clear", () =>
      this.act("Fault cleared.", () => this.source().clearFaults(this.device)),
    );
    this.release = new Action("release", () =>
      this.act("Force released.", () => this.source().release(this.device)),
    );
  }

  /** Null: not known yet, so that nothing is possible. */
  rights(mayControl: boolean | null): void {
    this.mayControl = mayControl;
    offerKey(mayControl === false);
    if (mayControl !== null) return;
    say(this.said, "");
    this.clear.set(false, ASKING);
    this.release.set(false, ASKING);
  }

  /** The same device again, after its stream was lost, changes nothing. */
  show(device: Device): void {
    if (device.name !== this.device) say(this.said, "");
    this.device = device.name;
  }

  state(device: Device, state: DeviceState): void {
    const allowed = this.mayControl === true;
    const refusal = this.mayControl === false ? ONLY_LOOKS : ASKING;
    const fault = state.faults !== 0;
    this.clear.set(
      fault && allowed,
      !fault
        ? "There is no fault."
        : allowed
          ? "Force stays off until the program asks for it again."
          : refusal,
    );
    const force = state.state === Lifecycle.ENGAGED || state.state === Lifecycle.ENGAGING;
    this.release.set(
      force && allowed,
      !force
        ? "No force is on."
        : allowed
          ? `Takes the device from “${device.controller}”; force fades out softly.`
          : refusal,
    );
  }

  private async act(done: string, call: () => Promise<void>): Promise<void> {
    say(this.said, "Asking …");
    try {
      await call();
      say(this.said, done);
    } catch (error) {
      if (error instanceof SourceError && error.reason === "RIGHTS") this.rights(false);
      if (error instanceof SourceError && error.reason === "LEASE_HELD") offerKey(true);
      say(this.said, refused(error));
    }
  }
}

/** A way to show a key that allows more. */
function offerKey(on: boolean): void {
  at("other-key").hidden = !on;
}

function refused(error: unknown): string {
  if (!(error instanceof SourceError)) return `Refused: ${String(error)}`;
  switch (error.reason) {
    case "RIGHTS":
      return `Refused. ${ONLY_LOOKS}`;
    case "FAULT_PERSISTS":
      return `Not cleared, because the cause is still there: ${error.message}`;
    case "STOPPED_LOCALLY":
      return "Not cleared: the stop was pressed on hapticd's own computer. Clear it there.";
    case "LEASE_HELD":
      return (
        "Refused: the program that holds the device has the same rank as this page's key, so " +
        "only it may release. Stop works always."
      );
    default:
      return `Refused: ${error.message}`;
  }
}
