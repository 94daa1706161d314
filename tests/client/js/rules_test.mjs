// Decisions of the package without a server.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { test } from "node:test";
import { part } from "./package_under_test.mjs";

const haptic = await part("index.js");
const { create } = createRequire(process.env.HAPTICD_JS + "/")("@bufbuild/protobuf");
const { closeError, httpError } = await part("errors.js");
const { Reconnection } = await part("reconnection.js");
const { NewestState } = await part("newest_state.js");
const { proxySample } = await part("sample.js");
const { openSession } = await part("session_options.js");
const { RoundTrip } = await part("round_trip.js");

const linear = (n) => Array.from({ length: n }, () => ({ kind: "linear" }));
const close = (actual, expected) => {
  assert.equal(actual.length, expected.length);
  actual.forEach((value, i) => assert.ok(Math.abs(value - expected[i]) < 1e-12, `${actual}`));
};

test("angles differ the short way round", () => {
  close(haptic.difference([{ kind: "angle" }], [3], [-3]), [6 - 2 * Math.PI]);
  close(haptic.difference([{ kind: "linear" }], [3], [-3]), [6]);
});

test("quaternions take the nearer sign", () => {
  const kinds = [{ kind: "linear" }, ...Array(4).fill({ kind: "quaternion" })];
  close(haptic.difference(kinds, [1, 0, 0, 0, -1], [0, 0, 0, 0.6, 0.8]), [1, 0, 0, -0.6, 0.2]);
});

test("the deepest 32 planes stay", () => {
  const planes = Array.from({ length: 40 }, (_, i) => ({ normal: [2], offset: i }));
  const kept = haptic.keepDeepest(linear(1), [0], [5], planes);
  assert.deepEqual(kept, planes.slice(0, 32));
});

test("eight contacts may share coordinates", () => {
  const contact = (id, normal, offset) => ({ id, normal, offset });
  const planes = Array.from({ length: 10 }, (_, i) => contact(i + 1, [1, 0], 10 - i));
  planes.push(contact(11, [0, 1], 99));
  assert.deepEqual(haptic.keepDeepest(linear(2), [0, 0], [0, 0], planes).map(({ id }) => id),
                   [3, 4, 5, 6, 7, 8, 9, 10, 11]);
});

test("a curvature without room becomes 0", () => {
  const planes = Array.from({ length: 12 }, (_, i) => ({
    id: i + 1, normal: linear(96).map((_, k) => (k >> 3 === i ? 1 : 0)), offset: i,
    curvature: Array(36).fill(1), firstCoordinate: 8 * i, uncertainty: 0,
  }));
  const none = Array(96).fill(0);
  const kept = haptic.keepDeepest(linear(96), none, none, planes);
  assert.deepEqual(kept.map(({ curvature }) => curvature.length), Array(12).fill(0));
  assert.ok(kept.every((plane) => plane.uncertainty === undefined));
  const small = planes.map((plane) => ({ ...plane, normal: plane.normal.slice(0, 44) }));
  const few = haptic.keepDeepest(linear(44), none.slice(0, 44), none.slice(0, 44), small);
  assert.equal(few.filter(({ curvature }) => curvature.length > 0).length, 8);  // 320 / 36
});

test("a close frame names code and reason", () => {
  const { code, reason, message } = closeError(4006, "LEASE_HELD: wall has it");
  assert.deepEqual([code, reason, message], ["already_exists", "LEASE_HELD", "wall has it"]);
  assert.equal(closeError(4014, "the front ends").reason, "UNAVAILABLE");
  assert.equal(closeError(1000, "").code, "ok");
  for (const lost of [1006, 1011, 4000 + 17, 5000]) {
    assert.equal(closeError(lost, "").code, "unavailable");
  }
});

test("an error's reason comes from ErrorInfo", () => {
  const body = (text) => httpError(404, new TextEncoder().encode(text));
  const info = Buffer.from("\x0a\x0eNO_SUCH_DEVICE\x12\x07hapticd").toString("base64")
    .replace(/=+$/, "");
  const error = body(JSON.stringify({ code: "not_found", message: "no device 'x'",
    details: [{ type: "google.rpc.ErrorInfo", value: info }] }));
  assert.deepEqual([error.code, error.reason, error.message],
                   ["not_found", "NO_SUCH_DEVICE", "no device 'x'"]);
  for (const odd of ["", "<html>", "[]", "null", '{"code":7,"details":[null,{"type":1}]}',
    '{"details":[{"type":"google.rpc.ErrorInfo","value":"!"}]}']) {
    assert.deepEqual([body(odd).code, body(odd).message], ["unimplemented", "HTTP status 404"]);
  }
});

test("attempts follow each other slower", () => {
  const reconnection = new Reconnection(true);
  const lost = closeError(1006, "");
  const delays = [1, 2, 3, 4, 5].map(() => reconnection.ended(lost, 0));
  assert.deepEqual(delays, [0, 100, 200, 400, 500]);
  assert.equal(reconnection.ended(closeError(4003, "PROTOCOL: OpenSession did not come"), 0), 500);
  assert.equal(reconnection.ended(closeError(4003, "INVALID_ARGUMENT: x"), 0), undefined);
  assert.equal(reconnection.over, true);
  assert.equal(new Reconnection(false).ended(lost, 0), undefined);
});

test("attempts are 100 ms apart", () => {
  const reconnection = new Reconnection(true);
  for (const [lived, delay] of [[0, 100], [30, 70], [100, 0], [5000, 0]]) {
    reconnection.begin(1000);
    reconnection.opened();
    assert.equal(reconnection.ended(closeError(1006, ""), 1000 + lived), delay);
  }
});

test("round trips rise at once", () => {
  const roundTrip = new RoundTrip();
  const after = (seq, sent, came) => {
    roundTrip.published(seq, sent);
    roundTrip.used(seq, came);
    return roundTrip.value;
  };
  assert.equal(after(1n, 0, 10), 10);
  assert.equal(after(2n, 20, 46), 26);
  assert.equal(after(3n, 50, 60), 25);
  roundTrip.used(2n, 1000);
  assert.equal(roundTrip.value, 25);
});

test("a sample names the state given", () => {
  const given = { seq: 7n, receivedMs: 10, xProbe: [1] };
  const sample = (proxy, state) => {
    const { seq, deviceSeqUsed, holdUs, sourceTimeNs } = proxySample(proxy, [], 3n, state, 12.5);
    return [seq, deviceSeqUsed, holdUs, sourceTimeNs];
  };
  assert.deepEqual(sample(haptic.Proxy.held([1]), given), [3n, 7n, 2500, 12500000n]);
  assert.deepEqual(sample({ ...haptic.Proxy.held([1]), deviceSeqUsed: 5n }, given),
                   [3n, 5n, 0, 12500000n]);
  assert.deepEqual(sample(haptic.Proxy.free(), undefined), [3n, 0n, 0, 12500000n]);
});

test("a newer state is not given yet", async () => {
  const states = new NewestState();
  const state = (seq) => create(haptic.DeviceStateSchema, { seq, xProbe: [Number(seq)] });
  const waited = states.wait(1000);
  assert.equal(states.take(state(4n), 10), true);
  assert.equal(states.take(state(4n), 11), false);
  assert.equal((await waited).seq, 4n);
  states.take(state(5n), 12);
  assert.deepEqual(states.given, { seq: 4n, receivedMs: 10, xProbe: [4] });
  assert.equal(states.give().seq, 5n);
  assert.equal(states.given.receivedMs, 12);
  assert.equal((await states.wait(1000)).seq, 5n);
  await assert.rejects(states.wait(20), { code: "deadline_exceeded" });
  const last = states.wait(1000);
  states.end(closeError(1000, ""));
  await assert.rejects(last, { code: "ok" });
});

test("who is slow gets the newest state", async () => {
  const states = new NewestState();
  const waiting = states.wait(1000);
  for (const seq of [1n, 2n, 3n]) states.take({ seq, xProbe: [] }, 0);  // one message each
  assert.equal((await waiting).seq, 3n);
  assert.equal(states.given.seq, 3n);
});

test("who waited first gets it too", async () => {
  const states = new NewestState();
  const state = (seq) => ({ seq, xProbe: [] });
  states.take(state(4n), 0);
  await states.wait(1000);
  const first = states.wait(1000);
  states.take(state(5n), 0);  // the first wakes after the messages that are here already
  const both = await Promise.all([first, states.wait(1000)]);
  assert.deepEqual(both.map(({ seq }) => seq), [5n, 5n]);
  const third = states.wait(1000);
  states.restart();
  states.take(state(1n), 0);
  assert.equal((await third).seq, 1n);
});

test("a wrong address is refused at once", () => {
  for (const url of ["", "127.0.0.1:29473", "ftp://x", "http://x/path", "unix:x"]) {
    assert.throws(() => new haptic.Connection(url), { code: "invalid_argument" });
  }
  assert.throws(() => new haptic.Connection("http://x", { token: "a b" }),
                { code: "invalid_argument" });
});

test("a session opens as told", () => {
  const options = { role: "observer", priority: "operator", holdEndMs: 1500.25 };
  const opening = openSession(options, "", 5n);
  assert.equal(opening.role, haptic.Role.OBSERVER);
  assert.equal(opening.priority, haptic.Priority.OPERATOR);
  assert.deepEqual(opening.holdEnd, { seconds: 1n, nanos: 500250000 });
  assert.equal(opening.freshEnd, undefined);
  assert.deepEqual([opening.nominalRateHz, opening.stateRateHz], [60, 60]);
});

const device = create(haptic.DeviceSchema, {
  dofs: [{ name: "mcp", unit: "rad", actuated: true }, { name: "slide", unit: "m", actuated: true },
         { name: "pip", unit: "rad" }],
  coordinates: [{ name: "x", unit: "m" }],
});

test("a table has names and units", () => {
  const state = create(haptic.DeviceStateSchema, {
    state: haptic.DeviceStateName.ENGAGED, tauA: [1.5, -2], faults: 0x80000002, xProbe: [0.25],
  });
  const fields = Object.fromEntries(
    haptic.stateFields(device, state).map((field) => [field.name, field]));
  assert.deepEqual(fields.tau_a, {
    name: "tau_a", kind: "number", repeated: true, axis: "actuated", labels: ["mcp", "slide"],
    units: ["N m", "N"], values: [1.5, -2], fields: [] });
  assert.deepEqual(fields.stiffness_in_effect.units, ["N m/rad", "N/m"]);
  assert.deepEqual(fields.q.labels, ["mcp", "slide", "pip"]);
  assert.deepEqual([fields.state.values, fields.mode.values], [["ENGAGED"], ["NONE"]]);
  assert.deepEqual(fields.faults.values, ["DEVICE_SILENT|31"]);
  assert.deepEqual(fields.server_time_ns.units, ["ns"]);
  assert.deepEqual(fields.passivity.fields.map(({ values }) => values), [[], [], [], [], []]);
});
