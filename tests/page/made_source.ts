// A stand-in for the server in tests of the page alone: two devices whose states are made by hand,
// and everything that a server may answer, set by the test through `window.made`.

import {
  ClientError, type Device, type Event, type GetServerInfoResponse, type SessionLink,
} from "hapticd";
import type { Listener, Source } from "../../server/front/page/src/live_source";
import { madeDevices, madeState, message } from "./made_device";

export interface Made {
  key: boolean; // the page has one
  control: boolean; // that allows more than to look
  gone: boolean; // the server does not answer
  faults: number;
    listener: Listener | null;
  stops: number;
  refuseStops: number;
  clears: string[];
  lose(): void; // the stream of states
}

const wished = window as { noKey?: boolean; observe?: boolean };

export const made: Made = {
  key: !wished.noKey,
  control: !wished.observe,
  gone: false,
  faults: 0,
  listener: null,
  stops: 0,
  refuseStops: 0,
  clears: [],
  lose: () => made.listener?.ended(new ClientError("unavailable", "UNAVAILABLE", "it was lost")),
};

const RATE_HZ = 60;
const EMERGENCY_STOP = 1 << 7;

const duration = (ms: number) => ({ seconds: 0n, nanos: ms * 1e6 });

export class MadeSource implements Source {
  constructor(private readonly token?: string) {}

  private answer<T>(value: T): Promise<T> {
    if (made.gone) return Promise.reject(new ClientError("unavailable", "UNAVAILABLE", "gone"));
    if (made.key || this.token === "0123456789abcdef") return Promise.resolve(value);
    return Promise.reject(new ClientError("unauthenticated", "UNAUTHENTICATED", "no key"));
  }

  devices(): Promise<Device[]> {
    return this.answer(madeDevices());
  }

  serverInfo(): Promise<GetServerInfoResponse> {
    return this.answer(message<GetServerInfoResponse>({
      version: "0.1.0",
      scene: "made by hand",
      realtime: { grade: "best-effort", explanation: "no SCHED_FIFO: not permitted" },
      loop: {
        skipped: 3n,
        latenessP50Us: 18 + 4 * Math.random(),
        latenessP99Us: 80 + 30 * Math.random(),
        latenessMaxUs: 240 + 60 * Math.random(),
        tickP99Us: 21,
      },
      insecure: ["gRPC on 127.0.0.1:29471 is not encrypted."],
      maxSessions: 8,
      sessions: 2,
      uptime: { seconds: 7384n, nanos: 0 },
    }));
  }

  links(): Promise<SessionLink[]> {
    const link = message<SessionLink>({
      device: "finger",
      clientName: "soft-grasp",
      role: 1,
      holdsLease: true,
      samplesBy: 2,
      statesBy: 2,
      transports: [
        { transport: 1 },
        {
          transport: 2,
          up: { lost: 4n, rejected: [{ reason: "OLD_SEQUENCE", count: 2n }] },
          roundTrip: duration(12.3),
        },
      ],
      ageP50: duration(9.1),
      ageP99: duration(14.8),
    });
    const page = message<SessionLink>({
      device: "finger",
      clientName: "page in a browser",
      role: 2,
      holdsLease: false,
      samplesBy: 0,
      statesBy: 3,
      transports: [{ transport: 3 }],
    });
    return this.answer([link, page]);
  }

  watch(device: string, listener: Listener) {
    made.listener = listener;
    const begin = performance.now();
    const timer = setInterval(() => {
      const t = (performance.now() - begin) * 1e-3;
      listener.state(madeState(device, t, made.faults));
    }, 1000 / RATE_HZ);
    const { lose } = made;
    made.lose = () => {
      clearInterval(timer);
      lose();
    };
    listener.event(message<Event>({ kind: 9, serverTimeNs: 1n, reason: "LEASE_GRANTED",
                                    message: "lease granted to 'soft-grasp'" }));
    return { close: () => clearInterval(timer) };
  }

  mayControl(): Promise<boolean> {
    return Promise.resolve(made.control || this.token !== undefined);
  }

  stop(): Promise<string[]> {
    made.stops++;
    if (made.refuseStops > 0) {
      made.refuseStops--;
      return Promise.reject(new ClientError("unavailable", "UNAVAILABLE", "no answer"));
    }
    made.faults |= EMERGENCY_STOP;
    return this.answer(["finger", "hand"]);
  }

  clearFaults(device: string): Promise<void> {
    made.clears.push(device);
    made.faults = 0;
    return Promise.resolve();
  }

  release(): Promise<void> {
    return Promise.reject(new ClientError("already_exists", "LEASE_HELD", "held by soft-grasp"));
  }
}
