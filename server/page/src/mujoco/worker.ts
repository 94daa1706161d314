// The engine and its session with hapticd, away from what paints: a slow picture delays no sample.

import { ClientError, Connection, Proxy, type Session } from "hapticd";
import type { Order, Report, Timing } from "./messages";
import { World } from "./world";

const RATE_HZ = 60;
const LONGEST_MS = 50; // of simulated time at once
const REMEMBERED = 600; // frames

const say = (report: Report, moved: Transferable[] = []): void =>
  postMessage(report, { transfer: moved });
const tell = (text: string, reason = ""): void => say({ kind: "said", text, reason });

function explain(error: unknown): void {
  if (!(error instanceof ClientError)) return tell(String(error), "UNKNOWN");
  tell(error.message, error.code === "unauthenticated" ? "NO_KEY" : error.reason);
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

/** Until the session ends for good. */
async function run(session: Session, world: World): Promise<void> {
  const frames = new Frames();
  let timing = frames.timing, since = 0, last = 0n;
  for (;;) {
    const state = await session.waitForState();
    if (resets) {
      resets = false;
      session.publish(Proxy.free()); // force ends by the server's ramp, whatever it was
      world.reset();
    }
    const begin = performance.now();
    // Of states that come too fast for this computer the newest alone is seen.
    const passed = last === 0n ? 1000 / RATE_HZ : Number(state.serverTimeNs - last) * 1e-6;
    last = state.serverTimeNs;
    session.publish(world.step(state.xProbe, Math.min(passed, LONGEST_MS), session.roundTripMs));
    frames.add(performance.now() - begin);
    const places = world.places(), probe = world.placesOfProbe(state.xProbe);
    const points = world.pointsOfProbe(state.xProbe), presses = world.presses();
    if (timing.frames === 0 || ++since % 30 === 0) timing = frames.timing;
    say({
      kind: "frame", places, probe, points, presses, timing, state: state.state,
      forces: state.tauA, following: world.tool.following,
    }, [places.buffer, probe.buffer, points.buffer, presses.buffer]);
  }
}

async function start(scene: string, token?: string): Promise<void> {
  tell("Opening the device …");
  const server = new Connection(undefined, token === undefined ? {} : { token });
  session = await server.open({
    clientName: "MuJoCo in a browser", nominalRateHz: RATE_HZ, stateRateHz: RATE_HZ,
    reconnect: true, reEngage: true,
    onDisconnect: (why, willRetry) =>
      tell(willRetry ? "Connecting again …" : why.message, why.reason),
  });
  tell("Loading MuJoCo …");
  const folder = new URL("./", self.location.href).href;
  const engine = import(`${folder}mujoco.js`).then(({ default: load }) => load());
  const xml = fetch(`${folder}${scene}.xml`).then((answer) => answer.text());
  world = new World(await engine, await xml, session.device);
  say({
    kind: "scene", device: session.device.name, geoms: world.geoms(), up: world.up(),
    motors: session.device.dofs.filter(({ actuated }) => actuated)
      .map(({ name, unit }) => ({ name, unit: unit === "m" ? "N" : "N m" })),
  });
  tell("");
  await run(session, world);
}

addEventListener("message", ({ data }: MessageEvent<Order>) => {
  if (data.kind === "start") start(data.scene, data.token).catch(explain);
  else if (data.kind === "engage") session?.engageWhenReady();
  else if (data.kind === "release") session?.release().catch(explain);
  else resets = true;
});
