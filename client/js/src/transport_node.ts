/** HTTP and WebSockets of Node, also over a UNIX socket, and with a client certificate. */
import * as http from "node:http";
import * as https from "node:https";
import { httpError, localError } from "./errors.js";
import { NodeSocket } from "./node_socket.js";
import { MAX_ANSWER } from "./transport.js";
import type { Answer, SocketListener, Target, Transport } from "./transport.js";

/** Begins a request to `path`; throws if the address is none. */
function request(target: Target, path: string, options: http.RequestOptions): http.ClientRequest {
  const headers = { ...options.headers as http.OutgoingHttpHeaders };
  if (target.token !== undefined) headers["Authorization"] = `Bearer ${target.token}`;
  if (target.url.startsWith("unix:")) {
    const socketPath = target.url.slice("unix:".length);
    return http.request({ ...options, headers, socketPath, path, host: "localhost" });
  }
  const url = new URL(path, target.url);
  return url.protocol === "https:" ? https.request(url, { ...options, headers, ...target.tls })
                                   : http.request(url, { ...options, headers });
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
    const headers = { "Content-Type": type, "Content-Length": Buffer.byteLength(body) };
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
                 listener: SocketListener): NodeSocket {
  return new NodeSocket((headers) => request(target, path, { headers, agent: false }), protocol,
                        listener, (response) => read(response, MAX_ANSWER).then(
                          (body) => httpError(response.statusCode ?? 0, body)));
}

export const transport: Transport = {
  defaultUrl: () => "http://127.0.0.1:29473", post, connect,
  afterMessages: (act) => void setImmediate(act),
};
