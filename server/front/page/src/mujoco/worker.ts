// The engine and its session with hapticd, away from what paints: a slow picture delays no sample.

import {
  ClientError, Connection, effortUnit, Proxy, type DeviceState, type Session,
} from "hapticd";
import type { Order, Report, Timing } from "./messages";
import { World } from "./world";

const RATE_HZ = 60;
const LONGEST_MS = 50; // of simulated time at once
const REMEMBERED = 600; // frames

const say = (report: Report, moved: Transferable[] = []): void =>
  postMessage(report, { transfer: moved });
const tell = (text: string, reason = ""): void => say({ kind: "said", text, reason });

function explain(error: unknown): void {
  if (error instanceof RangeError) {
    return tell(`This scene is not for this device: ${error.message}. Choose another.`, "SCENE");
  }
  if (!(error instanceof ClientError)) return tell(String(error), "UNKNOWN");
  tell(error.message, error.code === "unauthenticated" ? "NO_KEY" : error.reason || "UNKNOWN");
}

const UNSTEADY = ["STREAM_TOO_YOUNG", "TOO_FEW_SAMPLES", "STREAM_STALE"];

/** Why force waits; empty: it does not. */
function refusalOf({ engageRefusal: refusal }: Session): string {
  if (!refusal) return "";
  return !UNSTEADY.includes(refusal.reason) ? refusal.message
    : "this computer has to keep up with the device for a moment. If this stays, it is too slow";
}

class Frames {
  private readonly taken: number[] = [];
  private frames = 0;
  add(ms: number): void {
    this.taken[this.frames++ % REMEMBERED] = ms;
  }
  get timing(): Timing {
    const sorted = [...this.taken].sort((a, b) => a - b);
    const at = (part: number) => sorted[Math.floor(part * (sorted.length - 1))] ?? 0;
    return { median: at(0.5), p99: at(0.99), frames: this.frames };
  }
}

let session: Session | undefined;
let world: World | undefined;
let resets = false;
let shown = true; // what was sent to the page last
let lost = false; // the session has no stream, and connects again

/** The next one, however long the server or this computer stands still. */
async function nextState(session: Session): Promise<DeviceState> {
  for (;;) {
    try {
      return await session.waitForState();
    } catch (error) {
      if (!(error instanceof ClientError) || error.code !== "deadline_exceeded") throw error;
    }
  }
}

/** Until the session ends for good. */
async function run(session: Session, world: World): Promise<void> {
  const frames = new Frames();
  let timing = frames.timing, timed = 0, last = 0n;
  for (;;) {
    const state = await nextState(session);
    if (lost) tell("");
    lost = false;
    if (resets) {
      resets = false;
      session.publish(Proxy.free()); // force ends by the server's ramp, whatever it was
      world.reset();
    }
    const begin = performance.now();
    // Only the newest is seen of states that come too fast for this computer. Another server's
    // clock may be behind.
    const passed = last === 0n || state.serverTimeNs <= last ? 1000 / RATE_HZ
      : Number(state.serverTimeNs - last) * 1e-6;
    last = state.serverTimeNs;
    const { xProbe } = state;
    session.publish(world.tool.step(xProbe, Math.min(passed, LONGEST_MS), session.roundTripMs));
    frames.add(performance.now() - begin);
    if (!shown) continue;
    shown = false;
    const places = world.places(), probe = world.placesOfProbe(xProbe);
    const points = world.pointsOfProbe(xProbe), { presses, touched } = world.presses();
    if (performance.now() - timed > 500) {
      timing = frames.timing;
      timed = performance.now();
    }
    say({
      kind: "frame", places, probe, points, presses, touched, timing, state: state.state,
      refusal: refusalOf(session), forces: state.tauA,
      following: world.tool.following,
    }, [places.buffer, probe.buffer, points.buffer, presses.buffer]);
  }
}

async function start(scene: string, token?: string): Promise<void> {
  tell("Loading MuJoCo …");
  const folder = new URL("./", self.location.href).href;
  const [mujoco, xml] = await Promise.all([
    import(`${folder}mujoco.js`).then(({ default: load }) => load()),
    fetch(`${folder}${scene}.xml`).then((answer) => answer.text()),
  ]);
  tell("Opening the device …"); // not before: a session that publishes nothing loses its lease
  const server = new Connection(undefined, token === undefined ? {} : { token });
  session = await server.open({
    clientName: "MuJoCo in a browser", nominalRateHz: RATE_HZ, stateRateHz: RATE_HZ,
    reconnect: true, reEngage: true,
    onDisconnect: (why, willRetry) => {
      lost = willRetry;
      if (willRetry) tell("Connecting again …");
      else explain(why);
    },
  });
  let said = "";
  world = new World(mujoco, xml, session.device, (text) => tell(said = text));
  say({
    kind: "scene", device: session.device.name, geoms: world.geoms(), up: world.up(),
    motors: session.device.dofs.filter(({ actuated }) => actuated)
      .map(({ name, unit }) => ({ name, unit: effortUnit(unit) })),
  });
  tell(said);
  await run(session, world);
}

addEventListener("message", ({ data }: MessageEvent<Order>) => {
  if (data.kind === "start") start(data.scene, data.token).catch(explain);
  else if (data.kind === "engage") session?.engageWhenReady();
  else if (data.kind === "release") session?.release().catch(explain);
  else if (data.kind === "shown") shown = true;
  else resets = true;
});
