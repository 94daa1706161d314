// The server, by the client library.

import { bitNames, ClientError, Connection } from "hapticd";
import type { Device } from "./model";
import { SourceError, type Listener, type Source, type Watching } from "./source";

/** States per second: as often as a screen shows a picture. */
const STATES_HZ = 60;
const IMPOSSIBLE_HZ = -1;
const STOP_MS = 1000;
const NAME = "page in a browser";

function asSourceError(error: unknown): SourceError {
  return error instanceof ClientError
    ? new SourceError(error.code, error.reason, error.message)
    : new SourceError("unknown", "UNKNOWN", String(error));
}

/** Names of all 32 bits; the library calls one without a name by its number. */
function names(field: "faults" | "limiters"): string[] {
  return Array.from({ length: 32 }, (_, bit) => {
    const name = bitNames(field, 1 << bit)[0];
    return name === undefined || name === String(bit) ? "-" : name;
  });
}

export class LiveSource implements Source {
  readonly faultNames = names("faults");
  readonly limiterNames = names("limiters");
  private readonly server: Connection;
  private readonly stopper: Connection;

  constructor(token?: string) {
    const options = token === undefined ? {} : { token };
    this.server = new Connection(undefined, options);
    this.stopper = new Connection(undefined, { ...options, timeoutMs: STOP_MS });
  }

  devices(): Promise<Device[]> {
    return this.call(() => this.server.listDevices());
  }
  serverInfo() {
    return this.call(() => this.server.serverInfo());
  }
  links() {
    return this.call(async () => (await this.server.linkStats()).sessions);
  }

  watch(device: string, listener: Listener): Watching {
    let open = true;
    const end = (error: unknown): void => {
      if (open) listener.ended(asSourceError(error));
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

  /** Asks to control the device, with a rate that is refused to everyone: which refusal comes
   * tells whether the key would allow it, and nothing changes. */
  async mayControl(device: string): Promise<boolean> {
    const error = await this.server
      .open({ device, clientName: NAME, stateRateHz: IMPOSSIBLE_HZ })
      .then((session) => session.close(), asSourceError);
    return error?.reason !== "RIGHTS";
  }

  stop(): Promise<string[]> {
    return this.call(() => this.stopper.emergencyStop("", "stop on the page"));
  }

  async clearFaults(device: string): Promise<void> {
    await this.call(() => this.server.clearFault(device));
  }

  async release(device: string): Promise<void> {
    const take = (priority: "primary" | "operator") =>
      this.call(() =>
        this.server.open({ device, priority, clientName: NAME, stateRateHz: 1 }),
      );
    const session = await take("operator").catch((error: SourceError) => {
      if (error.reason === "PRIORITY_DENIED") return take("primary");
      throw error;
    });
    await session.close();
  }

  private async call<T>(make: () => Promise<T>): Promise<T> {
    try {
      return await make();
    } catch (error) {
      throw asSourceError(error);
    }
  }
}
