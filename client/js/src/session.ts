/** A session with one device: publish where the proxy is, receive the device's states, ask for
 * force. Connection.open() makes one.
 *
 * The *haptic probe* is where the device is in the virtual space; the *proxy* is where the
 * simulation's objects let it be. The server renders a force that pulls the probe to the proxy. The
 * *lease* is a controller's right to the device; it expires after a while without samples. */
import type { Calls } from "./calls.js";
import { ClientError, localError } from "./errors.js";
import { Force, endOfForce } from "./force.js";
import { HapticService } from "./gen/haptic/v1/haptic_service_pb.js";
import type { Device, UpdateSettingsResponse } from "./gen/haptic/v1/haptic_service_pb.js";
import { DeviceStateName, Event_Kind } from "./gen/haptic/v1/session_pb.js";
import type { DeviceState, Event, SessionOpened, SessionResponse }
  from "./gen/haptic/v1/session_pb.js";
import { NewestState } from "./newest_state.js";
import { keepDeepest } from "./proxy.js";
import type { Pose, Proxy } from "./proxy.js";
import { Reconnection, endsLease } from "./reconnection.js";
import { RoundTrip } from "./round_trip.js";
import { proxySample, trackerSample } from "./sample.js";
import { openSession } from "./session_options.js";
import type { SessionOptions, Settings } from "./session_options.js";
import { Statistics } from "./statistics.js";
import type { PublishStatistics } from "./statistics.js";
import { Stream } from "./stream.js";
import type { Request } from "./stream.js";

const FAREWELL_MS = 500;
const HAS_FORCE = new Set([DeviceStateName.ENGAGING, DeviceStateName.ENGAGED]);

export class Session {
  /** The device as it was at the first opening. */
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
  #statistics = new Statistics();

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

  // The way up.

  /** Sends where the proxy is now. Never waits, never throws. The newest sample wins: one that
   * could not be sent yet is replaced and counted; without a stream it is dropped. */
  publish(proxy: Proxy): void {
    this.#offer((seq) => {
      const nowMs = performance.now(), given = this.#states.given, planes = proxy.planes ?? [];
      const fitting = planes.length === 0 ? planes : keepDeepest(
        this.device.coordinates, proxy.position, given?.xProbe ?? [], planes);
      this.#statistics.counts.planesLeftOut += planes.length - fitting.length;
      this.#roundTrip.published(seq, nowMs);
      return { case: "proxy", value: proxySample(proxy, fitting, seq, given, nowMs) };
    });
  }

  /** The same for the poses of a tracker. */
  publishPose(pose: Pose): void {
    this.#offer((seq) => ({ case: "tracker", value: trackerSample(pose, seq) }));
  }

  // The way down.

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

  /** True if the session has a stream. */
  get connected(): boolean {
    return this.#reconnection.open;
  }
  /** Rises with every lease; 0: none. */
  get leaseEpoch(): number {
    return this.#opened?.leaseEpoch ?? 0;
  }
  /** The server's answer to the opening, with the staleness limits in force. */
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
    return { ...this.#statistics.counts };
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
    const stream = this.#stream, open = this.connected;
    const closed = new ClientError("ok", "CLOSED", "the session was closed");
    this.#reconnection.state = "closed";
    this.#reconnection.why = closed;
    this.#stream = undefined;
    this.#force.giveUp(closed);
    clearTimeout(this.#retry);
    this.#states.end(closed);
    if (open) await stream?.leave(FAREWELL_MS);
    stream?.cancel(closed);
  }

  // The stream.

  #offer(make: (seq: bigint) => Request): void {
    const seq = BigInt(++this.#statistics.counts.published);
    if (this.#reconnection.state === "leaseLost" && this.#options.reconnect) {
      // Only a new session controls the device. It begins with this sample and not before, so that
      // a silent client does not hold the device.
      this.#stream?.cancel(localError("aborted", "the lease had expired, or was preempted"));
    }
    try {
      this.#stream?.offer(make(seq));
    } catch (error) {  // not what the types say
      this.#statistics.counts.lastRejection = String(error);
    }
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
      this.#reconnection.begin(performance.now());
      const resume = this.#force.releaseOwed || !this.#options.reconnect ? "" :
        this.#opened?.sessionId ?? "";
      const value = openSession(this.#options, resume, this.#newestEventNs);
      const { target, format, timeoutMs } = this.#calls;
      const stream = new Stream(target, format, { case: "open", value }, {
        message: (message) => {
          if (message.case !== "opened") return this.#take(message);
          clearTimeout(timer);
          this.#takeOpened(message.value);
          resolve();
        },
        sent: (replaced) => this.#statistics.sent(replaced),
        end: (why) => {
          clearTimeout(timer);
          reject(why);
          if (stream === this.#stream) this.#ended(why);
        },
      });
      const timer = setTimeout(() => stream.cancel(localError(
        "deadline_exceeded", `no answer to OpenSession in ${timeoutMs} ms`)), timeoutMs);
      this.#stream = stream;
    });
  }

  #ended(why: ClientError): void {
    const first = this.#opened === undefined, wasOpen = this.connected;
    const delay = first ? undefined : this.#reconnection.ended(why, performance.now());
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
    this.#statistics.opened();
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
    if (message.case === "ack") this.#statistics.acknowledged(message.value);
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
    const { role = "controller", reEngage = false } = this.#options;
    if (role === "controller" && endsLease(event, this.leaseEpoch)) this.#reconnection.leaseLost();
    const end = endOfForce(event, this.leaseEpoch, reEngage);
    if (end !== undefined) this.#force.giveUp(end);
    this.#options.onEvent?.(event);
  }
}
