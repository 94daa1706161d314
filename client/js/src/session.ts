/** A session with one device: publish where the proxy is, receive the device's states, ask for
 * force. Connection.open() makes one.
 *
 * The *haptic probe* is where the device is in the virtual space; the *proxy* is where the
 * simulation's objects let it be. The server renders a force that pulls the probe to the proxy. The
 * *lease* is a controller's right to the device; it expires after a while without samples. */
import type { Calls } from "./calls.js";
import { ClientError, localError } from "./errors.js";
import { Force } from "./force.js";
import { HapticService } from "./gen/haptic/v1/haptic_service_pb.js";
import type { Device, UpdateSettingsResponse } from "./gen/haptic/v1/haptic_service_pb.js";
import { DeviceStateName, Event_Kind } from "./gen/haptic/v1/session_pb.js";
import type { DeviceState, Event, SampleAck, SessionOpened, SessionResponse }
  from "./gen/haptic/v1/session_pb.js";
import { NewestState } from "./newest_state.js";
import { keepDeepest } from "./proxy.js";
import type { Pose, Proxy } from "./proxy.js";
import { Reconnection } from "./reconnection.js";
import { RoundTrip } from "./round_trip.js";
import { NO_STATISTICS, openSession } from "./session_options.js";
import type { PublishStatistics, SessionOptions, Settings } from "./session_options.js";
import { Stream } from "./stream.js";

const FAREWELL_MS = 500;
const HAS_FORCE = new Set([DeviceStateName.ENGAGING, DeviceStateName.ENGAGED]);

export class Session {
  /** As it was at the first opening. */
  readonly device: Device;
  #calls: Calls;
  #options: SessionOptions;
  #stream: Stream | undefined;
  #reconnection: Reconnection;
  #force: Force;
  #opened: SessionOpened | undefined;
  #states = new NewestState();
  #newestEventNs = 0n;
  #retry: ReturnType<typeof setTimeout> | undefined;
  #roundTrip = new RoundTrip();
  #statistics: PublishStatistics = { ...NO_STATISTICS };
  #earlier: PublishStatistics = NO_STATISTICS;  // when the stream opened, whose acknowledgements begin at 0

  /** Use Connection.open(). */
  static async open(calls: Calls, options: SessionOptions): Promise<Session> {
    const session = new Session(calls, options);
    await session.#connect();
    try {
      const { devices } = await calls.call(HapticService.method.listDevices, {});
      const device = devices.find(({ name }) => name === session.#opened?.device);
      if (device === undefined) throw localError("not_found", "the device is not listed");
      (session as { device: Device }).device = device;
      return session;
    } catch (error) {
      await session.close();  // the caller gets no session: give the lease back now
      throw error;
    }
  }

  private constructor(calls: Calls, options: SessionOptions) {
    this.#calls = calls;
    this.#options = options;
    this.device = undefined as never;  // open() has it before the caller has this
    this.#reconnection = new Reconnection(options.reconnect ?? false);
    const nextLease = (options.reEngage ?? false) && (options.reconnect ?? false);
    this.#force = new Force({
      mayAsk: () => !HAS_FORCE.has(this.#states.newest?.state ?? DeviceStateName.UNSPECIFIED) &&
        (this.#reconnection.state === "open" ||
         (this.#reconnection.state === "leaseLost" && !nextLease)),
      id: () => this.#opened?.sessionId ?? "",
      engage: () => this.#engage(),
    }, options.reEngage ?? false, nextLease);
  }

  // What goes up.

  /** Sends where the proxy is now. Never waits, never throws. The newest sample wins: one that
   * could not be sent yet is replaced and counted; without a stream it is dropped. */
  publish(proxy: Proxy): void {
    try {
      const nowMs = performance.now(), given = this.#states.given, planes = proxy.planes ?? [];
      const fitting = planes.length === 0 ? planes : keepDeepest(
        this.device.coordinates, proxy.position, given?.xProbe ?? [], planes);
      const used = proxy.deviceSeqUsed ?? given?.seq ?? 0n;
      const hold = used !== 0n && used === given?.seq ? (nowMs - given.receivedMs) * 1000 : 0;
      const seq = this.#nextSeq();
      this.#statistics.planesLeftOut += planes.length - fitting.length;
      this.#roundTrip.published(seq, nowMs);
      this.#stream?.offer({ case: "proxy", value: {
        seq, sourceTimeNs: BigInt(Math.round(nowMs * 1e6)), deviceSeqUsed: used,
        holdUs: Math.min(Math.max(Math.trunc(hold), 0), 0xffffffff),
        validForUs: proxy.validForUs ?? 0, position: [...proxy.position], mode: proxy.mode,
        planes: fitting.map((plane) => ({ ...plane })),
      } });
    } catch (error) {  // not what the types say
      this.#statistics.lastRejection = String(error);
    }
  }

  /** The same for the poses of a tracker. */
  publishPose(pose: Pose): void {
    try {
      this.#stream?.offer({ case: "tracker", value: {
        seq: this.#nextSeq(), validForUs: pose.validForUs ?? 0, position: [...pose.position],
        orientation: [...pose.orientation],
      } });
    } catch (error) {
      this.#statistics.lastRejection = String(error);
    }
  }

  // What comes down.

  /** The newest state; undefined before the first one and after the session started again. The
   * next sample counts as computed from it. */
  state(): DeviceState | undefined {
    return this.#states.give();
  }

  /** Resolves to a state newer than the last one that this call gave. Rejects with
   * DEADLINE_EXCEEDED, or why the session ended. */
  waitForState(): Promise<DeviceState> {
    if (this.#reconnection.over) return Promise.reject(this.#reconnection.why);
    return this.#states.wait(this.#calls.timeoutMs);
  }

  /** The newest state again and again, until close(). Throws what waitForState() rejects with. */
  async *states(): AsyncGenerator<DeviceState, void> {
    while (this.#reconnection.state !== "closed") {
      try {
        yield await this.waitForState();
      } catch (error) {
        if (this.#reconnection.state as string !== "closed") throw error;
      }
    }
  }

  /** Whether the session has a stream. */
  get connected(): boolean {
    return this.#reconnection.open;
  }
  /** Rises with every lease; 0: none. */
  get leaseEpoch(): number {
    return this.#opened?.leaseEpoch ?? 0;
  }
  /** What the server answered to the opening, with the staleness limits in force. */
  get opened(): SessionOpened {
    return this.#opened!;
  }
  /** From publish() to the arrival of the first state that used the sample, ms: rises at once,
   * falls slowly. 0: not known yet. */
  get roundTripMs(): number {
    return this.#roundTrip.value;
  }
  /** Why engageWhenReady() has no force yet, or why it gave up; undefined after the server agreed.
   */
  get engageRefusal(): ClientError | undefined {
    return this.#force.refusal;
  }
  statistics(): PublishStatistics {
    return { ...this.#statistics };
  }

  // Force.

  /** Asks for force once. Rejects and says what is missing. */
  async engage(): Promise<void> {
    await this.#engage();
    if (this.#options.reEngage) this.#force.want();
  }

  /** Asks for force in the background, every 50 ms, until the server agrees. Gives up on a refusal
   * that waiting does not change, on a fault, and, without reEngage, when force is lost. */
  engageWhenReady(): void {
    this.#force.want();
  }

  /** Gives force up; it fades out. Also ends engageWhenReady(). */
  async release(): Promise<void> {
    await this.#force.release();
    if (!this.connected) {
      this.#force.releaseOwed = true;  // force fades out, unless the session is resumed with it
      return;
    }
    await this.#calls.call(HapticService.method.release, { sessionId: this.#sessionId() });
  }

  updateSettings(settings: Settings): Promise<UpdateSettingsResponse> {
    return this.#calls.call(HapticService.method.updateSettings,
                            { ...settings, sessionId: this.#sessionId() });
  }

  /** Ends the session; the server lets force fade out. No callback follows. Resolves when the
   * server heard it, after 500 ms at the latest; a page that goes away need not wait. */
  async close(): Promise<void> {
    const stream = this.#stream, closed = new ClientError("ok", "CLOSED", "the session was closed");
    this.#reconnection.state = "closed";
    this.#reconnection.why = closed;
    this.#stream = undefined;
    this.#force.giveUp(closed);
    clearTimeout(this.#retry);
    this.#states.end(closed);
    if (stream === undefined) return;
    stream.leave();
    await Promise.race([stream.ended, new Promise((done) => setTimeout(done, FAREWELL_MS))]);
    stream.cancel(closed);
  }

  // The stream.

  #nextSeq(): bigint {
    ++this.#statistics.published;
    if (this.#reconnection.state === "leaseLost" && this.#options.reconnect) {
      // Only a new session controls the device. It begins with this sample and not before, so that
      // a silent client does not hold the device.
      this.#stream?.cancel(localError("aborted", "the lease had expired, or was preempted"));
    }
    return BigInt(this.#statistics.published);
  }

  #sessionId(): string {
    if (!this.connected || this.#opened === undefined) {
      throw new ClientError("failed_precondition", "CLOSED", "the session is not open");
    }
    return this.#opened.sessionId;
  }

  async #engage(): Promise<void> {
    await this.#calls.call(HapticService.method.engage, { sessionId: this.#sessionId() });
  }

  /** Opens a stream; resolves when the server agreed. */
  #connect(): Promise<void> {
    return new Promise((resolve, reject) => {
      this.#reconnection.state = "opening";
      const resume = this.#force.releaseOwed || !this.#options.reconnect ? "" :
        this.#opened?.sessionId ?? "";
      const value = openSession(this.#options, resume, this.#newestEventNs);
      const timer = setTimeout(() => stream.cancel(localError(
        "deadline_exceeded", `no answer to OpenSession in ${this.#calls.timeoutMs} ms`)),
        this.#calls.timeoutMs);
      const stream = new Stream(this.#calls.target, this.#calls.format, { case: "open", value }, {
        message: (message) => {
          if (message.case !== "opened") return this.#take(message);
          clearTimeout(timer);
          this.#takeOpened(message.value);
          resolve();
        },
        sent: (replaced) => {
          ++this.#statistics.sent;
          this.#statistics.conflated += replaced;
        },
        end: (why) => {
          clearTimeout(timer);
          reject(why);
          if (stream === this.#stream) this.#ended(why);
        },
      });
      this.#stream = stream;
    });
  }

  #ended(why: ClientError): void {
    const first = this.#opened === undefined, wasOpen = this.connected;
    const delay = first ? undefined : this.#reconnection.ended(why);
    const again = delay !== undefined;
    this.#stream = undefined;
    if (first) this.#reconnection.state = "over";
    if (!again || !this.#options.reEngage) this.#force.giveUp(why);
    if (again) this.#retry = setTimeout(() => void this.#connect().catch(() => undefined), delay);
    else this.#states.end(why);
    if (!first && (wasOpen || !again)) this.#options.onDisconnect?.(why, again);
  }

  #takeOpened(opened: SessionOpened): void {
    this.#opened = opened;
    this.#reconnection.opened();
    this.#earlier = { ...this.#statistics };
    if (!opened.resumed) {
      this.#states.restart();
      this.#force.releaseOwed = false;
    } else if (this.#force.releaseOwed) {
      this.#force.releaseOwed = false;
      void this.release().catch(() => undefined);
    }
  }

  #take(message: SessionResponse["message"]): void {
    if (this.#reconnection.state === "closed") return;
    if (message.case === "state") this.#takeState(message.value);
    if (message.case === "event") this.#takeEvent(message.value);
    if (message.case === "ack") this.#takeAck(message.value);
  }

  #takeState(state: DeviceState): void {
    const nowMs = performance.now();
    if (!this.#states.take(state, nowMs)) return;
    this.#roundTrip.used(state.proxySeqUsed, nowMs);
    // A fault may have latched while the stream was down: its event is then never seen.
    if (state.state === DeviceStateName.FAULT) this.#force.faultSeen();
    if (this.#options.onState) {
      this.#states.give();
      this.#options.onState(state);
    }
  }

  #takeEvent(event: Event): void {
    if (event.kind !== Event_Kind.TRANSPORT) this.#newestEventNs = event.serverTimeNs;
    // The end of an earlier session's lease may still be told to a session that opens just then.
    const ofThisLease = event.leaseEpoch === this.leaseEpoch;
    const preempted = event.reason === "LEASE_PREEMPTED";
    const controls = (this.#options.role ?? "controller") === "controller";
    if (ofThisLease && controls && (preempted || event.kind === Event_Kind.LEASE_EXPIRED) &&
        this.#reconnection.state === "open") {
      this.#reconnection.state = "leaseLost";
    }
    const why = (reason: string, text: string): ClientError =>
      new ClientError("failed_precondition", reason, `${text}: ${event.message}`);
    if (ofThisLease && preempted) this.#force.giveUp(why("LEASE_HELD", "preempted"));
    if (event.kind === Event_Kind.FAULT) this.#force.giveUp(why(event.reason, "fault"));
    if (event.kind === Event_Kind.LOST && !this.#options.reEngage) {
      this.#force.giveUp(why("LOST", "force was lost"));
    }
    this.#options.onEvent?.(event);
  }

  #takeAck(ack: SampleAck): void {
    Object.assign(this.#statistics, {
      accepted: this.#earlier.accepted + Number(ack.accepted),
      rejectedOld: this.#earlier.rejectedOld + Number(ack.rejectedOld),
      rejectedInvalid: this.#earlier.rejectedInvalid + Number(ack.rejectedInvalid),
      backlog: this.#earlier.backlog + Number(ack.conflatedBacklog),
      lastRejection: ack.lastRejection,
    });
  }
}
