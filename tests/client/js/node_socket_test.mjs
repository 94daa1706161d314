// The WebSocket of Node's transport against a server that sends bytes as told.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { once } from "node:events";
import * as http from "node:http";
import { test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { part } from "./package_under_test.mjs";

const { NodeSocket, encodeFrame, FrameReader } = await part("node_socket.js");
const { httpError } = await part("errors.js");
const { transport } = await part("transport_node.js");
const { Stream } = await part("stream.js");

/** The answer to an upgrade, with `changes`. */
function upgrade(key, changes = {}) {
  const accept = createHash("sha1").update(key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11");
  const headers = { Upgrade: "websocket", Connection: "Upgrade",
    "Sec-WebSocket-Accept": accept.digest("base64"), "Sec-WebSocket-Protocol": "p", ...changes };
  return "HTTP/1.1 101 Switching Protocols\r\n" +
    Object.entries(headers).map(([name, value]) => `${name}: ${value}\r\n`).join("") + "\r\n";
}

/** Unmasked, as a server sends it. */
function frame(opcode, payload, first = 0x80 | opcode) {
  const bytes = Buffer.from(payload);
  if (bytes.length < 126) return Buffer.concat([Buffer.from([first, bytes.length]), bytes]);
  const head = Buffer.alloc(10);
  head[0] = first;
  head[1] = 127;
  head.writeBigUInt64BE(BigInt(bytes.length), 2);
  return Buffer.concat([head, bytes]);
}

/** A client's view of a server that answers the upgrade with `answer(key)`, and what the server
 * got. `talk(socket, stream)` runs when the connection is up. */
async function session(t, answer, talk = () => undefined) {
  const seen = { messages: [], upgraded: false, heard: Buffer.alloc(0) };
  const server = http.createServer();
  server.on("upgrade", (request, stream) => {
    stream.on("error", () => undefined).on("end", () => stream.end());
    stream.on("data", (bytes) => (seen.heard = Buffer.concat([seen.heard, bytes])));
    stream.write(answer(request.headers["sec-websocket-key"], stream));
    seen.stream = stream;
  });
  t.after(() => server.close());
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  const closed = new Promise((resolve) => {
    seen.socket = new NodeSocket(
      (headers) => http.request({ port: server.address().port, headers, agent: false }), "p", {
        open: () => ((seen.upgraded = true), talk(seen)),
        message: (data) => seen.messages.push(data),
        close: (code, reason, refused) => resolve({ code, reason, refused }),
      }, async (response) => httpError(response.statusCode, Buffer.alloc(0)));
  });
  seen.end = await closed;
  seen.stream?.destroy();
  return seen;
}

const closing = frame(8, [0x0f, 0xa6, ...Buffer.from("LEASE_HELD: by x")]);

test("messages come whole, close says why", async (t) => {
  const seen = await session(t, (key) => Buffer.concat([
    Buffer.from(upgrade(key)), frame(1, "text"), frame(1, "in ", 1), frame(9, "ping"),
    frame(0, "two frames"), frame(2, Buffer.alloc(65536, 7)), closing]));
  assert.deepEqual(seen.messages.slice(0, 2), ["text", "in two frames"]);
  assert.deepEqual(seen.messages[2], Buffer.alloc(65536, 7));
  assert.deepEqual([seen.end.code, seen.end.reason], [4006, "LEASE_HELD: by x"]);
});

test("bytes may come one by one", async (t) => {
  const seen = await session(t, (key) => upgrade(key), ({ stream }) => {
    const bytes = Buffer.concat([frame(1, "slow"), closing]);
    for (const byte of bytes) stream.write(Buffer.from([byte]));
  });
  assert.deepEqual(seen.messages, ["slow"]);
});

for (const [name, bytes, code] of [
  ["a masked frame", encodeFrame(1, Buffer.from("x")), 1002],
  ["an unknown opcode", frame(3, "x"), 1002],
  ["reserved bits", frame(1, "x", 0xc1), 1002],
  ["a control frame in pieces", frame(9, "x", 9), 1002],
  ["a continuation of nothing", frame(0, "x"), 1002],
  ["text within text", Buffer.concat([frame(1, "x", 1), frame(1, "y")]), 1002],
  ["text that is not UTF-8", frame(1, [0xff]), 1007],
  ["a frame beyond 64 KB", Buffer.from([0x82, 127, 0, 0, 0, 0, 0, 1, 0, 1]), 1009],
  ["pieces beyond 64 KB",
   Buffer.concat([frame(2, Buffer.alloc(40000), 2), frame(0, Buffer.alloc(40000))]), 1009],
]) {
  test(`${name} ends the session`, async (t) => {
    const seen = await session(t, (key) => upgrade(key), ({ stream }) => stream.write(bytes));
    assert.deepEqual(seen.messages, []);
    assert.equal(seen.end.code, code);
  });
}

test("a wrong upgrade is refused", async (t) => {
  for (const changes of [{ "Sec-WebSocket-Accept": "x" }, { "Sec-WebSocket-Protocol": "q" },
    { "Sec-WebSocket-Extensions": "permessage-deflate" }]) {
    const seen = await session(t, (key) => upgrade(key, changes));
    assert.equal(seen.upgraded, false);
    assert.equal(seen.end.code, 1006);
  }
});

test("an answer instead is told", async (t) => {
  const { end } = await session(t, () => "HTTP/1.1 401 Unauthorized\r\nContent-Length: 0\r\n\r\n");
  assert.equal(end.refused.code, "unauthenticated");
});

test("a server that vanishes is told", async (t) => {
  const { end } = await session(t, (key) => upgrade(key), ({ stream }) => stream.destroy());
  assert.equal(end.code, 1006);
});

test("close waits for the server", async (t) => {
  const seen = await session(t, (key) => upgrade(key), (s) => {
    s.socket.send("last");
    s.socket.close();
    s.socket.send("too late");
    setTimeout(() => s.stream.write(frame(8, [3, 232])), 20);
  });
  const frames = [...new FrameReader().read(unmasked(seen.heard))];
  assert.deepEqual(frames.map(({ opcode }) => opcode), [1, 8]);
  assert.equal(frames[0].payload.toString(), "last");
  assert.equal(seen.end.code, 1000);
});

/** Short frames of a client as a server would send them. */
function unmasked(bytes) {
  const out = [];
  for (let at = 0; at < bytes.length;) {
    const length = bytes[at + 1] & 0x7f, mask = bytes.subarray(at + 2, at + 6);
    assert.equal(bytes[at + 1] & 0x80, 0x80);
    const payload = bytes.subarray(at + 6, at + 6 + length).map((byte, i) => byte ^ mask[i & 3]);
    out.push(Buffer.from([bytes[at], length]), payload);
    at += 6 + length;
  }
  return Buffer.concat(out);
}

test("the newest sample waits for the network", async (t) => {
  const server = http.createServer();
  let far;
  server.on("upgrade", (request, stream) => {
    far = stream;
    stream.on("error", () => undefined).pause();
    stream.write(upgrade(request.headers["sec-websocket-key"],
                         { "Sec-WebSocket-Protocol": "haptic.v1.proto" }));
  });
  const alive = setInterval(() => far?.write(frame(2, "")), 500);  // a silent server is given up
  t.after(() => (clearInterval(alive), far.destroy(), server.close()));
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  let offered = 0, sent = 0, replaced = 0, ended;
  const stream = new Stream(
    { url: `http://127.0.0.1:${server.address().port}` }, "binary", { case: "open", value: {} },
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

test("a frame's bytes are RFC 6455's", () => {
  // Section 5.7: a masked "Hello".
  assert.deepEqual(encodeFrame(1, Buffer.from("Hello"), Buffer.from("37fa213d", "hex")),
                   Buffer.from("818537fa213d7f9f4d5158", "hex"));
});

test("an answer is bounded", async (t) => {
  const server = http.createServer((_, response) => {
    const chunk = Buffer.alloc(1 << 20);
    for (let i = 0; i < 6; ++i) response.write(chunk);
    response.end();
  });
  t.after(() => server.closeAllConnections());
  t.after(() => server.close());
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  const target = { url: `http://127.0.0.1:${server.address().port}` };
  await assert.rejects(transport.post(target, "/x", "application/json", "{}", 5000),
                       { code: "unavailable" });
});

test("silence ends a call", async (t) => {
  const server = http.createServer(() => undefined);
  t.after(() => server.closeAllConnections());
  t.after(() => server.close());
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  const target = { url: `http://127.0.0.1:${server.address().port}` };
  await assert.rejects(transport.post(target, "/x", "application/json", "{}", 50),
                       { code: "deadline_exceeded" });
});
