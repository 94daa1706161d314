/** A connection to hapticd: facts about the server and its devices, sessions, emergency stop. */
import { transport } from "#transport";
import { Calls } from "./calls.js";
import { localError } from "./errors.js";
import { Health, HealthCheckResponse_ServingStatus } from "./gen/grpc/health/v1/health_pb.js";
import { HapticService } from "./gen/haptic/v1/haptic_service_pb.js";
import type { Device, GetLinkStatsResponse, GetServerInfoResponse }
  from "./gen/haptic/v1/haptic_service_pb.js";
import { Session } from "./session.js";
import type { SessionOptions } from "./session_options.js";
import type { Format } from "./stream.js";
import type { TlsOptions } from "./transport.js";

export interface ConnectionOptions {
  /** A token of the server's scene. A page that hapticd serves needs none: its cookie counts. */
  token?: string | undefined;
  /** How messages travel: protobuf's bytes (default), or its JSON, for people who look at them. */
  format?: Format;
  /** How long a call waits for its answer, ms; default 5000. */
  timeoutMs?: number;
  /** Node only. */
  tls?: TlsOptions;
}

/** Every call rejects with ClientError. A device argument is a name of listDevices(); empty: the
 * only device, or, for emergencyStop() and linkStats(), all of them. */
export class Connection {
  readonly #calls: Calls;

  /** `url`: "http://host:port", "https://host:port", or in Node "unix:/path". Default: the server
   * of the page, or in Node "http://127.0.0.1:29473". Does not wait for the server. Throws
   * ClientError if it is no such address, or the token cannot be one. */
  constructor(url: string = transport.defaultUrl(), options: ConnectionOptions = {}) {
    if (!/^(https?:\/\/[^/]+\/?|unix:\/.*)$/.test(url)) {
      throw localError("invalid_argument", `'${url}': must be http://host:port or unix:/path`);
    }
    if (options.token !== undefined && !/^[\w-]+$/.test(options.token)) {
      throw localError("invalid_argument", "token: must be of A-Z, a-z, 0-9, _ and -");
    }
    const target = { url: url.replace(/\/$/, ""), token: options.token, tls: options.tls };
    this.#calls = new Calls(target, options.format ?? "binary", options.timeoutMs ?? 5000);
  }

  serverInfo(): Promise<GetServerInfoResponse> {
    return this.#calls.call(HapticService.method.getServerInfo, {});
  }

  async listDevices(): Promise<Device[]> {
    return (await this.#calls.call(HapticService.method.listDevices, {})).devices;
  }

  /** Opens a session, and waits until the server agrees. */
  open(options: SessionOptions = {}): Promise<Session> {
    return Session.open(this.#calls, options);
  }

  /** Stops the device: zero force at once, and the fault EMERGENCY_STOP until clearFault(). Needs
   * no session. Resolves to the devices that are in FAULT now. `reason`: for people. */
  async emergencyStop(device = "", reason = ""): Promise<string[]> {
    const { method } = HapticService;
    return (await this.#calls.call(method.emergencyStop, { device, reason })).stopped;
  }

  /** Clears latched faults. `faults`: bit numbers of DeviceState.faults; empty: all that are
   * active. Resolves to those that were cleared. */
  async clearFault(device = "", faults: number[] = []): Promise<number[]> {
    const { method } = HapticService;
    return (await this.#calls.call(method.clearFault, { device, faultIds: faults })).cleared;
  }

  /** Network figures of the open sessions. */
  linkStats(device = ""): Promise<GetLinkStatsResponse> {
    return this.#calls.call(HapticService.method.getLinkStats, { device });
  }

  /** True if the device is open and its loop is on time; without one, if that holds for all. */
  async healthy(device = ""): Promise<boolean> {
    const answer = await this.#calls.call(Health.method.check, { service: device });
    return answer.status === HealthCheckResponse_ServingStatus.SERVING;
  }
}
