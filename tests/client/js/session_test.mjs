// The client against a running hapticd.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Hapticd, engaged, eventually, hold, open } from "./hapticd_process.mjs";
import { part } from "./package_under_test.mjs";

const haptic = await part("index.js");
const { Proxy, DeviceStateName, Transport } = haptic;

test("device and server are told", async (t) => {
  const server = await Hapticd.start(t);
  for (const format of ["binary", "json"]) {
    const connection = server.connect("observe", { format });
    const [device] = await connection.listDevices();
    assert.equal(device.name, "finger");
    assert.deepEqual(device.dofs.map(({ actuated }) => actuated), [true, false]);
    assert.deepEqual(device.forceLimit, [25]);
    assert.equal((await connection.serverInfo()).scene, "one finger at rest");
    await eventually(() => connection.healthy("finger"));
    await assert.rejects(connection.healthy("hand"), { code: "not_found" });
  }
});

for (const format of ["binary", "json"]) {
  test(`force ramps up and is released, ${format}`, async (t) => {
    const server = await Hapticd.start(t);
    const reasons = [];
    const session = await open(t, server.connect("primary", { format }),
                               { onEvent: (event) => reasons.push(event.reason) });
    assert.equal(session.opened.transport, Transport.WEBSOCKET);
    session.engageWhenReady();
    const state = await hold(session, engaged);
    assert.equal(state.gain, 1);
    assert.equal(state.transport, Transport.WEBSOCKET);
    assert.equal(session.engageRefusal, undefined);
    await session.release();
    await hold(session, (s) => s.state === DeviceStateName.ARMED && s.gain === 0);
    await eventually(() => reasons.includes("RELEASING -> ARMED"));
    assert.ok(reasons.includes("ENGAGING -> ENGAGED"));
    const counts = session.statistics();
    assert.ok(counts.accepted > 10 && counts.accepted <= counts.published, JSON.stringify(counts));
    assert.equal(counts.rejectedInvalid, 0);
    assert.ok(session.roundTripMs > 0);
  });
}

test("a UNIX socket needs no token", async (t) => {
  const server = await Hapticd.start(t);
  const session = await open(t, new haptic.Connection(server.unix));
  await hold(session, (state) => state.proxySeqUsed > 5n);
});

test("silence ends force with events", async (t) => {
  const server = await Hapticd.start(t);
  const reasons = [];
  const session = await open(t, server.connect(),
                             { onEvent: (event) => reasons.push(event.reason) });
  session.engageWhenReady();
  await hold(session, engaged);
  const ends = ["HOLD -> FADE", "FADE -> LOST", "LOST"];
  await eventually(() => ends.every((reason) => reasons.includes(reason)), "force is lost");
  await eventually(() => session.state().tauElastic.every((force) => force === 0));
});

test("lost force comes back if wanted", async (t) => {
  const server = await Hapticd.start(t);
  let lost = false;
  const session = await open(t, server.connect(), {
    reEngage: true, onEvent: (event) => (lost ||= event.reason === "LOST") });
  await hold(session, (state) => state.proxySeqUsed > 25n);
  await session.engage();
  await hold(session, engaged);
  await eventually(() => lost);
  await hold(session, engaged);
});

test("refusals have the server's reason", async (t) => {
  const server = await Hapticd.start(t);
  const connection = server.connect();
  const session = await open(t, connection);
  await assert.rejects(session.engage(), (error) => error instanceof haptic.ClientError &&
    error.code === "failed_precondition" &&
    ["NOT_ARMED", "STREAM_STALE", "TOO_FEW_SAMPLES"].includes(error.reason));
  await assert.rejects(connection.open(), { code: "already_exists", reason: "LEASE_HELD",
                                            message: /test/ });
  await assert.rejects(connection.open({ device: "hand" }),
                       { code: "not_found", reason: "NO_SUCH_DEVICE" });
  await assert.rejects(connection.open({ nominalRateHz: -1 }), { code: "invalid_argument" });
  await assert.rejects(connection.clearFault("hand"), { reason: "NO_SUCH_DEVICE" });
});

test("rights bound what a token may", async (t) => {
  const server = await Hapticd.start(t);
  const observer = server.connect("observe");
  await assert.rejects(observer.open(), { code: "permission_denied", reason: "RIGHTS" });
  await assert.rejects(observer.clearFault(), { code: "permission_denied", reason: "RIGHTS" });
  await assert.rejects(server.connect("primary").open({ priority: "operator" }),
                       { code: "permission_denied" });
  const session = await open(t, observer, { role: "observer" });
  await session.waitForState();
  const stranger = new haptic.Connection(server.url);
  await assert.rejects(stranger.serverInfo(), { code: "unauthenticated" });
  await assert.rejects(stranger.open({ role: "observer" }), { code: "unauthenticated" });
  assert.deepEqual(await observer.emergencyStop("", "a test"), ["finger"]);
  await eventually(() => session.state().state === DeviceStateName.FAULT);
  assert.deepEqual(haptic.bitNames("faults", session.state().faults), ["EMERGENCY_STOP"]);
  assert.deepEqual(await server.connect().clearFault(), [7]);
});

test("a fault ends the asking", async (t) => {
  const server = await Hapticd.start(t);
  const connection = server.connect();
  const session = await open(t, connection, { reEngage: true });
  session.engageWhenReady();
  await hold(session, engaged);
  await connection.emergencyStop();
  await hold(session, () => session.engageRefusal !== undefined);
  await connection.clearFault();
  const before = session.statistics().published;
  await hold(session, (state) => {
    assert.ok(state.gain === 0, "force came back");
    return session.statistics().published > before + 50;
  });
});

test("a wrong sample is named", async (t) => {
  const server = await Hapticd.start(t);
  const session = await open(t, server.connect());
  session.publish(Proxy.held([0.1, 0.2, 0.3]));
  await eventually(() => session.statistics().rejectedInvalid === 1);
  assert.match(session.statistics().lastRejection, /position/);
  // Against the types: it still does not throw.
  session.publish(Proxy.behind([{ normal: [1, 0], offset: 0, id: -1 }], [0, 0]));
  assert.match(session.statistics().lastRejection, /Plane.id/);
  session.publish(undefined);
});

test("the deepest planes are sent", async (t) => {
  const server = await Hapticd.start(t);
  const session = await open(t, server.connect());
  const { xProbe } = await session.waitForState();
  const planes = Array.from({ length: 40 }, (_, i) =>
    ({ normal: [1, 0], offset: xProbe[0] + (i < 8 ? 0.1 : -0.1) }));
  session.publish(Proxy.behind(planes, xProbe));
  await eventually(() => session.statistics().accepted === 1);
  assert.equal(session.statistics().planesLeftOut, 8);
  await eventually(async () => ((await session.waitForState()).activePlanes & 1) === 1);
});

test("contacts are taken", async (t) => {
  const server = await Hapticd.start(t);
  const session = await open(t, server.connect());
  const { xProbe } = await session.waitForState();
  // The client's own proxy: 0.1 inside, and three quarters of that with the object.
  const x = [xProbe[0] - 0.025, xProbe[1]];
  session.publish(Proxy.behind([{ normal: [1, 0], offset: x[0] - 0.075, compliance: 3, id: 1,
                                  uncertainty: 0.1 }], x));
  await eventually(async () => (await session.waitForState()).errorBound.length > 0);
  assert.equal(session.statistics().rejectedInvalid, 0);
});

test("settings are clamped with a reason", async (t) => {
  const server = await Hapticd.start(t);
  const session = await open(t, server.connect());
  const applied = await session.updateSettings({ stiffness: [1e6] });
  assert.deepEqual(applied.stiffness, [1500]);
  assert.deepEqual(applied.clamped.map(({ field }) => field), ["stiffness[0]"]);
});

test("links are measured", async (t) => {
  const server = await Hapticd.start(t);
  const connection = server.connect();
  const session = await open(t, connection);
  await hold(session, (state) => state.proxySeqUsed > 5n);
  const { sessions: [link] } = await connection.linkStats();
  assert.deepEqual([link.device, link.clientName], ["finger", "test"]);
  assert.equal(link.samplesBy, Transport.WEBSOCKET);
});

test("leaving gives the lease back", async (t) => {
  const server = await Hapticd.start(t);
  const connection = server.connect();
  for (const clientName of ["first", "second"]) {
    const session = await open(t, connection, { clientName });
    assert.equal((await connection.listDevices())[0].controller, clientName);
    await session.close();
    assert.equal(session.connected, false);
    await assert.rejects(session.waitForState(), { reason: "CLOSED" });
    session.publish(Proxy.free());
  }
});

test("states end with close", async (t) => {
  const server = await Hapticd.start(t);
  const session = await open(t, server.connect("observe"), { role: "observer" });
  let seen = 0n;
  for await (const { seq } of session.states()) {
    assert.ok(seq > seen);
    if (seen !== 0n) await session.close();
    seen = seq;
  }
  await assert.rejects(session.engage(), { reason: "CLOSED" });
});

test("a server that dies is told", async (t) => {
  const server = await Hapticd.start(t);
  const told = [];
  const session = await open(t, server.connect(), {
    onDisconnect: (why, again) => told.push([why.code, again]) });
  await session.waitForState();
  await server.kill();
  await assert.rejects(eventually(async () => void await session.waitForState()),
                       { code: "unavailable" });
  assert.deepEqual(told, [["unavailable", false]]);
  await assert.rejects(server.connect().serverInfo(), { code: "unavailable" });
});
