// Connection and Session against a server that says what it must not: raw bytes on a socket. Each
// ends with a ClientError, or goes on, within its time and a bounded memory.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { once } from "node:events";
import { createRequire } from "node:module";
import * as net from "node:net";
import { test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { part } from "./package_under_test.mjs";

const { create, toBinary } = createRequire(process.env.HAPTICD_JS + "/")("@bufbuild/protobuf");
const { ClientError, Connection, Proxy } = await part("index.js");
const { ListDevicesResponseSchema } = await part("gen/haptic/v1/haptic_service_pb.js");
const { SessionResponseSchema } = await part("gen/haptic/v1/session_pb.js");

const SHORT_MS = 300, LONG_MS = 20000, MB = 1 << 20;

function agreed(request, protocol) {
  const key = /sec-websocket-key: (\S+)/i.exec(request)[1];
  const accept = createHash("sha1").update(key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11");
  return "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n" +
    `Sec-WebSocket-Protocol: ${protocol}\r\n` +
    `Sec-WebSocket-Accept: ${accept.digest("base64")}\r\n\r\n`;
}

/** Unmasked, as a server sends it. */
function frame(payload, first = 0x82) {
  const bytes = Buffer.from(payload), head = Buffer.alloc(4);
  head[0] = first;
  head[1] = 126;
  head.writeUInt16BE(bytes.length, 2);
  return Buffer.concat([bytes.length < 126 ? Buffer.from([first, bytes.length]) : head, bytes]);
}
const message = (value) =>
  frame(toBinary(SessionResponseSchema, create(SessionResponseSchema, { message: value })));
const opened = message({ case: "opened", value: { sessionId: "s", device: "finger" } });
const state = (seq, value) =>
  message({ case: "state", value: { seq: BigInt(seq), ...value } });
const listed = toBinary(ListDevicesResponseSchema, create(ListDevicesResponseSchema, {
  devices: [{ name: "finger", coordinates: [{ name: "a" }, { name: "b" }] }] }));
const answer = (body, head = "") => Buffer.concat([Buffer.from(
  "HTTP/1.1 200 OK\r\nContent-Type: application/proto\r\n" +
  `Content-Length: ${body.length}\r\nConnection: close\r\n${head}\r\n`), body]);

/** Sends `bytes` again and again until the other end is gone. */
async function endless(socket, bytes, pauseMs = 0) {
  while (!socket.destroyed) {
    if (!socket.write(bytes)) await Promise.race([once(socket, "drain"), once(socket, "close")]);
    await sleep(pauseMs);
  }
}

/** A server: `talk(socket, request)` after each request for a session, `call` after each call. */
async function serve(t, talk, call = (socket) => socket.end(answer(listed)), options = {}) {
  const sockets = new Set();
  const server = net.createServer((socket) => {
    sockets.add(socket);
    socket.on("error", () => undefined).on("close", () => sockets.delete(socket));
    socket.once("data", (bytes) => {
      const request = bytes.toString();
      Promise.resolve((request.startsWith("GET") ? talk : call)(socket, request))
        .catch(() => undefined);
    });
  });
  t.after(() => (sockets.forEach((socket) => socket.destroy()), server.close()));
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  return new Connection(`http://127.0.0.1:${server.address().port}`,
                        { timeoutMs: LONG_MS, ...options });
}
/** `talk` after the upgrade. */
const upgraded = (talk, protocol = "haptic.v1.proto") => (socket, request) => {
  socket.write(agreed(request, protocol));
  return talk(socket);
};
const sends = (...frames) => upgraded((socket) => frames.forEach((one) => socket.write(one)));

const waiting = (code) => ({ timeoutMs: code === "deadline_exceeded" ? SHORT_MS : LONG_MS });

/** The ClientError with which `promise` ends, in time, and without much memory. */
async function refusal(promise) {
  const began = performance.now(), before = process.memoryUsage().rss;
  const error = await promise.then(() => assert.fail("it was not refused"), (why) => why);
  assert.ok(error instanceof ClientError, String(error.stack));
  assert.ok(performance.now() - began < LONG_MS / 2, `after ${performance.now() - began} ms`);
  const grown = (process.memoryUsage().rss - before) / MB;
  assert.ok(grown < 100, `${grown} MB more`);
  return error;
}

for (const [name, talk, code, pattern] of [
  ["an end at once", (socket) => socket.destroy(), "unavailable", /no session/],
  ["no answer", () => undefined, "deadline_exceeded", /300 ms/],
  ["no HTTP", (socket) => socket.write("nonsense\r\n\r\n"), "unavailable", /no session/],
  ["200 in place of 101", (socket) => socket.end(answer(Buffer.from("<html>"))), "unknown", /200/],
  ["200 without an end", (socket) => {
    socket.write("HTTP/1.1 200 OK\r\n\r\n");
    return endless(socket, Buffer.alloc(MB));
  }, "unavailable", /./],
  ["a head without an end", (socket) => {
    socket.write("HTTP/1.1 101 Switching Protocols\r\n");
    return endless(socket, "X-Filler: " + "x".repeat(1000) + "\r\n");
  }, "unavailable", /no session/],
  ["a head of slow bytes", (socket) => {
    socket.write("HTTP/1.1 101 Switching Protocols\r\nX-Filler: ");
    return endless(socket, "x", 5);
  }, "deadline_exceeded", /300 ms/],
  ["an upgrade and silence", sends(), "deadline_exceeded", /300 ms/],
  ["pings without an end", upgraded((socket) => endless(socket, frame("ping", 0x89))),
   "deadline_exceeded", /300 ms/],
  ["bytes that come singly", upgraded((socket) => endless(socket, Buffer.from([0]), 1)),
   "unavailable", /opcode/],
  ["a huge length", sends(Buffer.from("827fffffffffffffffff", "hex")), "unavailable", /length/],
  ["a masked frame", sends(Buffer.from("828100000000aa", "hex")), "unavailable", /MASK/],
  ["a ping in pieces", sends(frame("x", 0x09)), "unavailable", /FIN/],
  ["a message of empty pieces", upgraded((socket) => {
    socket.write(frame("", 0x02));
    socket.write(Buffer.concat(Array(2000).fill(frame("", 0x00))));
  }), "unavailable", /fragments/],
  ["a cut message", sends(frame([0x12, 0x7f, 0x01])), "internal", /none/],
  ["a number without an end", sends(frame([0x12, 11, 8, ...Array(10).fill(255)])), "internal",
   /none/],
  ["a list of 12 bytes", sends(frame([0x12, 14, 0x1a, 12, ...Array(12).fill(1)])), "internal",
   /none/],
  ["groups 60000 deep", sends(frame(Buffer.alloc(60000, 0x7b))), "internal", /none/],
  ["text for bytes", sends(frame("[[{", 0x81)), "internal", /none/],
  ["text that is not UTF-8", sends(frame([0xff], 0x81)), "unavailable", /UTF-8/],
  ["an end with a code of its own", sends(frame([0, 1, 0xff], 0x88)), "unavailable", /./],
]) {
  test(`${name} is refused`, async (t) => {
    const server = await serve(t, talk, undefined, waiting(code));
    const error = await refusal(server.open());
    assert.equal(error.code, code, error.message);
    assert.match(error.message, pattern);
  });
}

for (const [name, text] of [["cut", '{"state":{'], ["60000 deep", "[".repeat(60000)],
  ["deep under a name", '{"x":'.repeat(12000)], ["not a state", '{"state":{"seq":{}}}'],
  ["a list", '{"state":{"q":["a"]}}'], ["no object", "7"]]) {
  test(`JSON that is ${name} is refused`, async (t) => {
    const talk = upgraded((socket) => socket.write(frame(text, 0x81)), "haptic.v1.json");
    const error = await refusal((await serve(t, talk, undefined, { format: "json" })).open());
    assert.equal(error.code, "internal", error.message);
  });
}

for (const [name, call, code] of [
  ["cut", (socket) => socket.end(answer(Buffer.from(listed.subarray(0, 9)))), "internal"],
  ["another device's", (socket) => socket.end(answer(Buffer.alloc(0))), "not_found"],
  ["longer than it is", (socket) => socket.end(answer(listed, "Content-Length: 99\r\n")),
   "unavailable"],
  ["an upgrade", (socket) => socket.write(agreed("sec-websocket-key: x", "p")),
   "deadline_exceeded"],
  ["slow bytes", (socket) => {
    socket.write("HTTP/1.1 200 OK\r\nContent-Type: application/proto\r\n" +
                 "Content-Length: 99999\r\n\r\n");
    return endless(socket, "x", 5);
  }, "deadline_exceeded"],
  ["in chunks without an end", (socket) => {
    socket.write("HTTP/1.1 200 OK\r\nContent-Type: application/proto\r\n" +
                 "Transfer-Encoding: chunked\r\n\r\n");
    return endless(socket, `${(MB).toString(16)}\r\n${"x".repeat(MB)}\r\n`);
  }, "resource_exhausted"],
  ["a page", (socket) => socket.end("HTTP/1.1 200 OK\r\nContent-Type: text/html\r\n\r\n<p>"),
   "unknown"],
  ["100 again and again", (socket) => endless(socket, "HTTP/1.1 100 Continue\r\n\r\n", 1),
   "deadline_exceeded"],
]) {
  test(`an answer that is ${name} is refused`, async (t) => {
    const error = await refusal((await serve(t, sends(opened), call, waiting(code))).open());
    assert.equal(error.code, code, error.message);
  });
}

test("states of another device harm nothing", async (t) => {
  const odd = [NaN, Infinity, -Infinity, 1e300, 5e-324];
  const session = await (await serve(t, sends(
    opened, state(1, {}), state(2, { q: odd, xProbe: odd, tauA: odd, gain: NaN }),
    state(3, { xProbe: Array(7000).fill(NaN), proxySeqUsed: 1n << 63n, state: 99 }),
    message({ case: "ack", value: { accepted: (1n << 64n) - 1n } }),
    message({ case: "event", value: { kind: 99, reason: "x" } })))).open();
  t.after(() => session.close());
  while (session.state()?.seq !== 3n) await session.waitForState();
  session.publish(Proxy.held([1, 2]));
  session.publish(Proxy.behind([{ normal: [1, NaN], offset: Infinity }], [1, 2]));
  assert.equal(session.connected, true);
});

test("a session that ends at once is opened slowly", async (t) => {
  let sessions = 0;
  const server = await serve(t, upgraded((socket) => {
    ++sessions;
    socket.write(opened);
    setTimeout(() => socket.destroy(), sessions === 1 ? 100 : 0);
  }));
  const session = await server.open({ reconnect: true });
  await sleep(1000);
  await session.close();
  assert.ok(sessions > 3 && sessions <= 12, `${sessions} in a second`);
});
