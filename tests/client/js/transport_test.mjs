// Node's transport: its WebSocket, which is the library ws, and its calls.
import assert from "node:assert/strict";
import { once } from "node:events";
import * as http from "node:http";
import { createRequire } from "node:module";
import { test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { part } from "./package_under_test.mjs";

const { WebSocketServer } = createRequire(process.env.HAPTICD_JS + "/")("ws");
const { transport } = await part("transport_node.js");
const { Calls } = await part("calls.js");
const { HapticService } = await part("gen/haptic/v1/haptic_service_pb.js");
const { Stream } = await part("stream.js");

const targetOf = (server) => ({ url: `http://127.0.0.1:${server.address().port}` });
const listed = (server, timeoutMs) =>
  new Calls(targetOf(server), "binary", timeoutMs).call(HapticService.method.listDevices, {});

/** A server of WebSockets; it ends with the test `t`. */
async function listen(t, options = {}) {
  const server = new WebSocketServer({ host: "127.0.0.1", port: 0, ...options });
  t.after(() => (server.clients.forEach((client) => client.terminate()), server.close()));
  await once(server, "listening");
  return server;
}

/** A client's view of a server that does `talk(socket)` when the connection is up; the client then
 * does `begin(client)`. */
async function session(t, talk, options = {}, begin = () => undefined) {
  const server = await listen(t, options), seen = { messages: [], upgraded: false };
  const closed = new Promise((resolve) => {
    const client = transport.connect(targetOf(server), "/x", "p", {
      open: () => ((seen.upgraded = true), begin(client)),
      message: (data) => seen.messages.push(data),
      close: (code, reason, refused) => resolve({ code, reason, refused }),
    });
    server.on("connection", talk);
  });
  seen.end = await closed;
  return seen;
}

test("messages come whole, close says why", async (t) => {
  const { messages, end } = await session(t, (socket) => {
    socket.send("text");
    socket.send("in ", { fin: false });
    socket.ping();
    socket.send("two frames");
    socket.send(Buffer.alloc(65536, 7));
    socket.close(4006, "LEASE_HELD: by x");
  });
  assert.deepEqual(messages, ["text", "in two frames", Buffer.alloc(65536, 7)]);
  assert.deepEqual([end.code, end.reason], [4006, "LEASE_HELD: by x"]);
});

test("a message beyond 64 KB ends the session", async (t) => {
  const { messages, end } = await session(t, (socket) => socket.send(Buffer.alloc(65537)));
  assert.deepEqual(messages, []);
  assert.match(end.reason, /size/);
});

test("another protocol or an extension is refused", async (t) => {
  const other = await session(t, () => undefined, { handleProtocols: () => "q" });
  assert.deepEqual([other.upgraded, other.end.code], [false, 1006]);
  const packed = (headers) => headers.push("Sec-WebSocket-Extensions: permessage-deflate");
  const server = await listen(t);
  server.on("headers", packed);
  const code = await new Promise((resolve) => transport.connect(targetOf(server), "/x", "p",
    { open: () => resolve("open"), message() {}, close: resolve }));
  assert.equal(code, 1006);
});

test("an answer instead is told", async (t) => {
  const { end } = await session(t, () => undefined,
                                { verifyClient: (_, done) => done(false, 401) });
  assert.equal(end.refused.code, "unauthenticated");
});

test("a server that vanishes is told", async (t) => {
  const { end } = await session(t, (socket) => socket.terminate());
  assert.equal(end.code, 1006);
});

test("close sends what came before it, and waits for the server", async (t) => {
  const heard = [];
  const listening = (socket) => socket.on("message", (data) => heard.push(String(data)));
  const { end } = await session(t, listening, {}, (client) => {
    client.send("last");
    client.close(1000);
  });
  assert.deepEqual(heard, ["last"]);
  assert.equal(end.code, 1000);
});

test("the newest sample waits for the network", async (t) => {
  const server = await listen(t);
  let far;
  server.on("connection", (socket) => (far = socket).pause());
  const alive = setInterval(() => far?.send(Buffer.alloc(0)), 500);  // a silent server is given up
  t.after(() => clearInterval(alive));
  let offered = 0, sent = 0, replaced = 0, ended;
  const stream = new Stream(
    targetOf(server), "binary", { case: "open", value: {} },
    { message() {}, end: (why) => (ended = why),
      sent: (before) => ((sent += 1), (replaced += before)) });
  t.after(() => stream.cancel(new Error("over")));
  const offer = () => stream.offer(
    { case: "proxy", value: { seq: BigInt(offered), position: Array(4000).fill(offered) } });
  while (sent === 0) offer(await sleep(1));  // before the upgrade nothing is kept
  // More than the system buffers: 16 MB. None of these calls waits.
  for (offered = 1; offered < 500; ++offered) {
    offer();
    if (offered % 10 === 0) await sleep(0);
  }
  assert.ok(sent < 500, `${sent} of ${offered} were sent`);
  far.resume();
  while (sent + replaced < 500) {  // until the newest went
    assert.equal(ended, undefined);
    await sleep(1);
  }
  assert.ok(replaced > 0);
});

test("an answer is bounded", async (t) => {
  const server = http.createServer((_, response) => {
    response.setHeader("Content-Type", "application/proto");
    const chunk = Buffer.alloc(1 << 20);
    for (let i = 0; i < 6; ++i) response.write(chunk);
    response.end();
  });
  t.after(() => server.closeAllConnections());
  t.after(() => server.close());
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  await assert.rejects(listed(server, 5000), { code: "resource_exhausted" });
});

test("silence ends a call", async (t) => {
  const server = http.createServer(() => undefined);
  t.after(() => server.closeAllConnections());
  t.after(() => server.close());
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  await assert.rejects(listed(server, 50), { code: "deadline_exceeded" });
});
