/** Options of a session, and what it tells of itself. */
import type { MessageInitShape } from "@bufbuild/protobuf";
import type { ClientError } from "./errors.js";
import type { UpdateSettingsRequestSchema } from "./gen/haptic/v1/haptic_service_pb.js";
import { Priority, Role } from "./gen/haptic/v1/session_pb.js";
import type { DeviceState, Event, OpenSessionSchema } from "./gen/haptic/v1/session_pb.js";

export interface SessionOptions {
  /** Its name; absent: the only device of the server. */
  device?: string;
  /** A controller publishes proxies (default), a tracker poses, an observer nothing. */
  role?: "controller" | "observer" | "tracker";
  /** Shown to other clients; 1 to 64 bytes of UTF-8. */
  clientName?: string;
  /** How often you will publish, Hz, 1 to 2000; default 60. */
  nominalRateHz?: number;
  /** How many states per second to receive; absent: the nominal rate; 0: one per tick. */
  stateRateHz?: number;
  /** A controller with a higher one takes the device from one with a lower; absent: primary. */
  priority?: "test" | "primary" | "operator";
  /** Ages of a sample at which it stops being fresh, its force begins to fade, and its force is
   * zero, ms. Each can shorten the scene's limit, not lengthen it. */
  freshEndMs?: number;
  holdEndMs?: number;
  fadeEndMs?: number;
  /** Takes up a lost stream again: at once, but 0.1 s after the attempt before began, then after
   * 0.1, 0.2, 0.4, 0.5, 0.5 ... s, until the server refuses for a reason that no waiting changes.
   * Resumes the session if its lease has not expired, else starts again without force. After a
   * lease expired or was preempted, the next published sample starts it again. */
  reconnect?: boolean;
  /** Asks for force again after it was lost because samples came too late or the stream was lost.
   * Never after a fault. */
  reEngage?: boolean;
  onState?(state: DeviceState): void;
  onEvent?(event: Event): void;
  /** The stream was lost; if `willRetry`, the session reconnects. */
  onDisconnect?(why: ClientError, willRetry: boolean): void;
}

/** One value per actuated DoF; what is absent or empty stays as it is. */
export type Settings = Omit<MessageInitShape<typeof UpdateSettingsRequestSchema>,
                            "sessionId" | "$typeName" | "$unknown">;

const ROLES = { controller: Role.CONTROLLER, observer: Role.OBSERVER, tracker: Role.TRACKER };
const PRIORITIES =
  { test: Priority.TEST, primary: Priority.PRIMARY, operator: Priority.OPERATOR };

/** The first message of a session. `resume`: session to go on with, or empty. */
export function openSession(options: SessionOptions, resume: string,
                            eventsAfterNs: bigint): MessageInitShape<typeof OpenSessionSchema> {
  const nominalRateHz = options.nominalRateHz ?? 60;
  const { freshEndMs, holdEndMs, fadeEndMs } = options;
  return {
    device: options.device ?? "",
    role: ROLES[options.role ?? "controller"],
    clientName: options.clientName ?? "haptic client",
    nominalRateHz,
    stateRateHz: options.stateRateHz ?? nominalRateHz,
    priority: options.priority === undefined ? Priority.UNSPECIFIED
                                             : PRIORITIES[options.priority],
    resumable: options.reconnect ?? false,
    resume,
    eventsAfterNs,
    ...(freshEndMs !== undefined && { freshEnd: duration(freshEndMs) }),
    ...(holdEndMs !== undefined && { holdEnd: duration(holdEndMs) }),
    ...(fadeEndMs !== undefined && { fadeEnd: duration(fadeEndMs) }),
  };
}

/** A Duration; `ms` may have a fraction. */
function duration(ms: number): { seconds: bigint; nanos: number } {
  const seconds = Math.trunc(ms / 1000);
  return { seconds: BigInt(seconds), nanos: Math.round((ms - seconds * 1000) * 1e6) };
}
