// A hapticd of a test's own, in a folder of its own. $HAPTICD and $HAPTIC_SCENES say where program
// and scenes are.
import { spawn } from "node:child_process";
import * as fs from "node:fs";
import * as os from "node:os";
import * as path from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { part } from "./package_under_test.mjs";

const { Connection, Proxy, DeviceStateName } = await part("index.js");

/** A token of the scene with these rights. */
export const tokenOf = (rights) => `${rights}-token-of-a-test`;

export async function eventually(condition, what = String(condition)) {
  const latest = Date.now() + 20000;
  for (let value = await condition(); ; value = await condition()) {
    if (value) return value;
    if (Date.now() > latest) throw new Error(`not so: ${what}`);
    await sleep(10);
  }
}

export class Hapticd {
  /** Starts it; it ends with the test `t`. */
  static async start(t, { scene = "finger_constant", settings = [] } = {}) {
    const server = new Hapticd(scene, settings);
    t.after(() => server.end());
    await server.begin();
    return server;
  }

  constructor(scene, settings) {
    this.folder = fs.mkdtempSync(path.join(os.tmpdir(), "haptic-js-"));
    this.unix = `unix:${this.folder}/web`;
    const tokens = ["observe", "primary", "operator"].map((rights) => {
      const file = path.join(this.folder, rights);
      fs.writeFileSync(file, tokenOf(rights), { mode: 0o600 });
      return `token {name: "${rights}" file: "${file}" rights: "${rights}"}`;
    });
    this.arguments = [
      "--scene", path.join(process.env.HAPTIC_SCENES, `${scene}.textproto`), "--realtime=off",
      "--listen", `unix:${this.folder}/grpc`,
      // A loaded machine is no fault of the client.
      "--set", "loop.late_bucket_full=1000000", "--set", "loop.loop_late_fault={seconds: 10}",
      "--set", "device[0].staleness={hold_end: {seconds: 1} fade_end: {seconds: 2}}",
      "--set", "server.lease_timeout={seconds: 4}",
      "--set", `server.web={listen: "127.0.0.1:0" listen: "${this.unix}" ${tokens.join(" ")}}`,
      ...settings.flatMap((setting) => ["--set", setting]),
    ];
  }

  async begin() {
    this.log = "";
    this.process = spawn(process.env.HAPTICD, this.arguments);
    for (const stream of [this.process.stdout, this.process.stderr]) {
      stream.on("data", (text) => (this.log += text));
    }
    const address = await eventually(() => {
      if (this.process.exitCode !== null) throw new Error(`hapticd ended: ${this.log}`);
      return /(127\.0\.0\.1:\d+) for browsers/.exec(this.log)?.[1];
    }, "hapticd serves browsers");
    this.url = `http://${address}`;
  }

  /** Ends the program at once; begin() starts another. */
  async kill() {
    const ended = new Promise((resolve) => this.process.once("exit", resolve));
    this.process.kill("SIGKILL");
    await ended;
  }

  async end() {
    if (this.process?.exitCode === null && this.process.signalCode === null) await this.kill();
    fs.rmSync(this.folder, { recursive: true });
  }

  /** Connects by TCP, with a token of these rights. */
  connect(rights = "primary", options = {}) {
    return new Connection(this.url, { token: tokenOf(rights), ...options });
  }
}

/** Opens a session that ends with the test. */
export async function open(t, connection, options = {}) {
  const session = await connection.open({ clientName: "test", nominalRateHz: 100, ...options });
  t.after(() => session.close());
  return session;
}

/** Publishes a proxy per state, until `until`: free, and as soon as there is force held at the
 * place where force began. */
export async function hold(session, until) {
  let place = (await session.waitForState()).xProbe, force = false;
  for (const latest = Date.now() + 20000; Date.now() < latest;) {
    session.publish(force ? Proxy.held(place) : Proxy.free());
    const state = await session.waitForState();
    if (until(state)) return state;
    force = state.gain > 0;
    if (!force) place = state.xProbe;
  }
  throw new Error(`still not so: ${until}, ${session.engageRefusal}`);
}

export const engaged = (state) => state.state === DeviceStateName.ENGAGED;
