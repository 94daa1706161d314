/** HTTP and WebSockets of Node, also over a UNIX socket, and with a client certificate. */
import * as http from "node:http";
import * as https from "node:https";
import * as net from "node:net";
import WebSocket from "ws";
import { httpError, localError } from "./errors.js";
import type { ClientError } from "./errors.js";
import { MAX_ANSWER, MAX_MESSAGE } from "./transport.js";
import type { Answer, Socket, SocketListener, Target, Transport } from "./transport.js";

const LOST = 1006;  // RFC 6455: no close frame came
/** Limits of a WebSocket. closeTimeout: ms that the server has to answer a close frame. */
const LIMITS = { perMessageDeflate: false, closeTimeout: 2000, maxPayload: MAX_MESSAGE,
                 maxFragments: 1024 };

/** Path of the UNIX socket; undefined: the URL is another. */
const unixPath = ({ url }: Target): string | undefined =>
  url.startsWith("unix:") ? url.slice("unix:".length) : undefined;
const bearer = ({ token }: Target): Record<string, string> =>
  token === undefined ? {} : { "Authorization": `Bearer ${token}` };

/** Begins a request to `path`; throws if the address is none. */
function request(target: Target, path: string, options: http.RequestOptions): http.ClientRequest {
  const socketPath = unixPath(target);
  if (socketPath !== undefined) {
    return http.request({ ...options, socketPath, path, host: "localhost" });
  }
  const url = new URL(path, target.url);
  return url.protocol === "https:" ? https.request(url, { ...options, ...target.tls })
                                   : http.request(url, options);
}

/** The body, up to `limit` bytes. */
async function read(response: http.IncomingMessage, limit: number): Promise<Uint8Array> {
  const chunks: Buffer[] = [];
  let size = 0;
  for await (const chunk of response) {
    size += chunk.length;
    if (size > limit) throw new Error(`the answer has more than ${limit} bytes`);
    chunks.push(chunk);
  }
  return Buffer.concat(chunks);
}

function post(target: Target, path: string, type: string, body: string | Uint8Array,
              timeoutMs: number): Promise<Answer> {
  return new Promise((resolve, reject) => {
    const headers = { ...bearer(target), "Content-Type": type,
                      "Content-Length": Buffer.byteLength(body) };
    const call = request(target, path, { method: "POST", headers });
    const fail = (error: Error): void => {
      clearTimeout(timer);
      reject(localError("unavailable", `no answer from ${target.url}: ${error.message}`));
      call.destroy();
    };
    const timer = setTimeout(() => {
      reject(localError("deadline_exceeded", `no answer in ${timeoutMs} ms`));
      call.destroy();
    }, timeoutMs);
    call.on("error", fail);
    call.on("response", (response) => {
      read(response, MAX_ANSWER).then((body) => {
        clearTimeout(timer);
        resolve({ status: response.statusCode ?? 0, body });
      }, fail);
    });
    call.end(body);
  });
}

function connect(target: Target, path: string, protocol: string,
                 listener: SocketListener): Socket {
  const unix = unixPath(target);
  const url = (unix === undefined ? target.url : "http://localhost").replace(/^http/, "ws");
  const socket = new WebSocket(url + path, protocol, {
    ...target.tls, ...LIMITS, headers: bearer(target),
    ...(unix !== undefined && { createConnection: () => net.connect(unix) }),
  });
  let over = false, failure = "";
  const end = (code: number, reason: string, refused?: ClientError): void => {
    if (!over) listener.close(code, reason, refused);
    over = true;
  };
  socket.on("open", () => listener.open());
  socket.on("message", (data: Buffer, binary) => listener.message(binary ? data : data.toString()));
  socket.on("error", ({ message }) => (failure = message));  // "close" follows
  socket.on("close", (code, reason) => end(code, reason.toString() || failure));
  socket.on("unexpected-response", (_, response) => {
    read(response, MAX_ANSWER).then(
      (body) => end(LOST, "", httpError(response.statusCode ?? 0, body)), () => end(LOST, ""));
  });
  return socket;
}

export const transport: Transport = {
  defaultUrl: () => "http://127.0.0.1:29473", post, connect,
  afterMessages: (act) => void setImmediate(act),
};
