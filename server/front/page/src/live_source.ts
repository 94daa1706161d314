// The page's door to the server: what it asks and hears, by the client library.

import { Connection, type ClientError, type DeviceState, type Event } from "hapticd";

/** States per second: as often as a screen shows a picture. */
const STATES_HZ = 60;
const IMPOSSIBLE_HZ = -1;
const STOP_MS = 1000;
const NAME = "page in a browser";

export interface Listener {
  state(state: DeviceState): void;
  event(event: Event): void;
  /** The stream ended; it does not come back by itself. */
  ended(error: ClientError): void;
}

/** The members of LiveSource, which a test has too. Every promise rejects with ClientError. */
export type Source = Pick<LiveSource, keyof LiveSource>;

export class LiveSource {
  private readonly server: Connection;
  private readonly stopper: Connection;

  constructor(token?: string) {
    this.server = new Connection(undefined, { token });
    this.stopper = new Connection(undefined, { token, timeoutMs: STOP_MS });
  }

  devices() {
    return this.server.listDevices();
  }
  serverInfo() {
    return this.server.serverInfo();
  }
  async links() {
    return (await this.server.linkStats()).sessions;
  }

  /** A stream of states; ends when it is closed. */
  watch(device: string, listener: Listener): { close(): void } {
    let open = true;
    const end = (error: ClientError): void => {
      if (open) listener.ended(error);
      open = false;
    };
    const session = this.server.open({
      device,
      role: "observer",
      clientName: NAME,
      stateRateHz: STATES_HZ,
      onState: (state) => open && listener.state(state),
      onEvent: (event) => open && listener.event(event),
      onDisconnect: end,
    });
    session.catch(end);
    return {
      close: () => {
        open = false;
        session.then((opened) => opened.close()).catch(() => undefined);
      },
    };
  }

  /** True if this page's key allows more than to look and to stop. Asks to control the device, with
   * a rate that is refused to everyone: which refusal comes tells, and nothing changes. */
  async mayControl(device: string): Promise<boolean> {
    const error = await this.server
      .open({ device, clientName: NAME, stateRateHz: IMPOSSIBLE_HZ })
      .then((session) => session.close(), (refused: ClientError) => refused);
    return error?.reason !== "RIGHTS";
  }

  /** All devices; answers with the names of those that are stopped. */
  stop(): Promise<string[]> {
    return this.stopper.emergencyStop("", "stop on the page");
  }

  async clearFaults(device: string): Promise<void> {
    await this.server.clearFault(device);
  }

  /** Takes the device from a program of lower priority, so that its force fades out; and leaves. */
  async release(device: string): Promise<void> {
    const take = (priority: "primary" | "operator") =>
      this.server.open({ device, priority, clientName: NAME, stateRateHz: 1 });
    const session = await take("operator").catch((error: ClientError) => {
      if (error.reason === "PRIORITY_DENIED") return take("primary");
      throw error;
    });
    await session.close();
  }
}
