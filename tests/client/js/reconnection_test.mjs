// A session that lost its stream, with a hapticd that goes on or starts again.
import assert from "node:assert/strict";
import { EventEmitter, once } from "node:events";
import * as net from "node:net";
import { test } from "node:test";
import { Hapticd, engaged, eventually, hold, open, tokenOf } from "./hapticd_process.mjs";
import { part } from "./package_under_test.mjs";

const { Connection, DeviceStateName, Proxy } = await part("index.js");

/** A way to the server that can be cut. */
class Cable {
  static async lay(t, server) {
    const cable = new Cable();
    cable.sockets = new Set();
    cable.listener = net.createServer((near) => {
      const far = net.connect(Number(new URL(server.url).port), "127.0.0.1");
      for (const [from, to] of [[near, far], [far, near]]) {
        cable.sockets.add(from);
        from.on("error", () => undefined).on("close", () => to.destroy()).pipe(to);
      }
    });
    cable.listener.listen(0, "127.0.0.1");
    await once(cable.listener, "listening");
    t.after(() => (cable.cut(), cable.listener.close()));
    return cable;
  }
  cut() {
    for (const socket of this.sockets) socket.destroy();
    this.sockets.clear();
  }
  connect() {
    const url = `http://127.0.0.1:${this.listener.address().port}`;
    return new Connection(url, { token: tokenOf("primary") });
  }
}

/** An engaged session over a cable, and what it told. */
async function engagedSession(t, server, options) {
  const cable = await Cable.lay(t, server);
  const told = [];
  const session = await open(t, cable.connect(), {
    onDisconnect: (why, again) => told.push(`${why.code} ${again}`),
    onEvent: (event) => told.push(event.reason), ...options });
  session.engageWhenReady();
  await hold(session, engaged);
  return { cable, session, told };
}

test("a lost stream is resumed with force", async (t) => {
  // A loaded machine reconnects slowly: a sample may be old for so long.
  const settings = ["device[0].staleness={hold_end: {seconds: 9} fade_end: {seconds: 10}}",
                    "server.lease_timeout={seconds: 20}"];
  const server = await Hapticd.start(t, { settings });
  const { cable, session, told } =
    await engagedSession(t, server, { reconnect: true, reEngage: true });
  const { leaseEpoch } = session;
  cable.cut();
  const state = await hold(session, (s) => session.leaseEpoch > leaseEpoch && engaged(s));
  assert.equal(state.gain, 1);
  await eventually(() => told.includes("LEASE_RESUMED"));
  assert.ok(told.includes("unavailable true"), told.join());
  assert.ok(!told.includes("LOST"), told.join());
  assert.equal(session.statistics().rejectedOld, 0);
});

test("without the wish it ends", async (t) => {
  const server = await Hapticd.start(t);
  const { cable, session, told } = await engagedSession(t, server, {});
  cable.cut();
  await assert.rejects(eventually(async () => void await session.waitForState()),
                       { code: "unavailable" });
  assert.equal(told.at(-1), "unavailable false");
  assert.equal(session.connected, false);
});

test("force that was released stays off", async (t) => {
  const server = await Hapticd.start(t);
  const lost = new EventEmitter();
  const { cable, session } = await engagedSession(
    t, server, { reconnect: true, onDisconnect: () => lost.emit("lost", session.release()) });
  cable.cut();
  await once(lost, "lost");
  await eventually(() => session.connected);
  await hold(session, (state) => state.gain === 0);  // if it was resumed just before
  const { published } = session.statistics();
  await hold(session, (state) => {
    assert.ok(!engaged(state));
    return session.statistics().published > published + 50;
  });
});

test("another server is joined without force", async (t) => {
  const server = await Hapticd.start(t);
  const reasons = [];
  const session = await open(t, new Connection(server.unix), {
    reconnect: true, onEvent: (event) => reasons.push(event.reason) });
  session.engageWhenReady();
  await hold(session, engaged);
  await server.kill();
  await eventually(() => !session.connected);
  session.publish(Proxy.free());  // dropped
  await server.begin();
  await eventually(() => session.connected);
  await hold(session, (state) => state.state === DeviceStateName.ARMED &&
    state.proxySeqUsed >= BigInt(session.statistics().published - 1));
  assert.equal(session.statistics().rejectedOld, 0);
});

test("the next sample takes an expired lease", async (t) => {
  const server = await Hapticd.start(t);
  const reasons = [];
  const session = await open(t, server.connect(), {
    reconnect: true, onEvent: (event) => reasons.push(event.reason) });
  session.publish(Proxy.free());
  const { leaseEpoch } = session;
  await eventually(() => reasons.includes("LEASE_EXPIRED"), "the lease expires");
  assert.equal(session.leaseEpoch, leaseEpoch);
  await hold(session, (state) => session.leaseEpoch > leaseEpoch && state.proxySeqUsed > 0n);
});
