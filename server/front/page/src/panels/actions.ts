// Clear fault and Release force, and why they are not possible.

import { ClientError, DeviceStateName, type Device, type DeviceState } from "hapticd";
import { at, say } from "../dom";
import type { Source } from "../live_source";

const ASKING = "Asking what this page may do …";
const ONLY_LOOKS = "This page's key allows looking and stopping only.";

export class Actions {
  private readonly said = at("action-said");
  private device = "";
  private mayControl: boolean | null = null;

  constructor(source: () => Source) {
    at("clear").addEventListener("click", () =>
      void this.act("Fault cleared.", () => source().clearFaults(this.device)));
    at("release").addEventListener("click", () =>
      void this.act("Force released.", () => source().release(this.device)));
  }

  /** Null: not known yet, so that nothing is possible. */
  rights(mayControl: boolean | null): void {
    this.mayControl = mayControl;
    offerKey(mayControl === false);
    if (mayControl === null) say(this.said, "");
  }

  /** The same device again, after its stream was lost, changes nothing. */
  show(device: Device): void {
    if (device.name !== this.device) say(this.said, "");
    this.device = device.name;
  }

  state({ controller }: Device, { faults, state }: DeviceState): void {
    const force = state === DeviceStateName.ENGAGED || state === DeviceStateName.ENGAGING;
    this.offer("clear", faults !== 0, "There is no fault.",
               "Force stays off until the program asks for it again.");
    this.offer("release", force, "No force is on.",
               `Takes the device from “${controller}”; force fades out softly.`);
  }

  /** A button with the sentence below it: `does`, or why it is not possible. */
  private offer(id: string, needed: boolean, not: string, does: string): void {
    const { mayControl } = this;
    at<HTMLButtonElement>(id).disabled = !needed || mayControl !== true;
    const refusal = mayControl === false ? ONLY_LOOKS : ASKING;
    say(at(`${id}-why`), !needed ? not : mayControl ? does : refusal);
  }

  private async act(done: string, call: () => Promise<void>): Promise<void> {
    say(this.said, "Asking …");
    try {
      await call();
      say(this.said, done);
    } catch (error) {
      const reason = error instanceof ClientError ? error.reason : "";
      if (reason === "RIGHTS") this.rights(false);
      if (reason === "LEASE_HELD") offerKey(true);
      say(this.said, refused(reason, error instanceof Error ? error.message : String(error)));
    }
  }
}

/** A way to show a key that allows more. */
function offerKey(on: boolean): void {
  at("other-key").hidden = !on;
}

function refused(reason: string, message: string): string {
  switch (reason) {
    case "RIGHTS":
      return `Refused. ${ONLY_LOOKS}`;
    case "FAULT_PERSISTS":
      return `Not cleared, because the cause is still there: ${message}`;
    case "STOPPED_LOCALLY":
      return "Not cleared: the stop was pressed on hapticd's own computer. Clear it there.";
    case "LEASE_HELD":
      return "Refused: the program that holds the device has the same rank as this page's key, " +
        "so only it may release. Stop works always.";
    default:
      return `Refused: ${message}`;
  }
}
