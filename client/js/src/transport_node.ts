/** HTTP and WebSockets of Node, also over a UNIX socket, and with a client certificate. */
import * as net from "node:net";
import type { Transport as Calls } from "@connectrpc/connect";
import { createConnectTransport } from "@connectrpc/connect-node";
import { sinkAllBytes } from "@connectrpc/connect/protocol";
import WebSocket from "ws";
import { httpError } from "./errors.js";
import type { ClientError } from "./errors.js";
import { MAX_ANSWER, MAX_MESSAGE, bearer } from "./transport.js";
import type { Socket, SocketListener, Target, Transport } from "./transport.js";

const LOST = 1006;  // RFC 6455: no close frame came
/** Limits of a WebSocket. closeTimeout: ms that the server has to answer a close frame. */
const LIMITS = { perMessageDeflate: false, closeTimeout: 2000, maxPayload: MAX_MESSAGE,
                 maxFragments: 1024 };

/** Path of the UNIX socket; undefined: the URL is another. */
const unixPath = ({ url }: Target): string | undefined =>
  url.startsWith("unix:") ? url.slice("unix:".length) : undefined;
const webUrl = (target: Target): string =>
  unixPath(target) === undefined ? target.url : "http://localhost";

function calls(target: Target, useBinaryFormat: boolean): Calls {
  return createConnectTransport({
    baseUrl: webUrl(target), useBinaryFormat, httpVersion: "1.1", acceptCompression: [],
    readMaxBytes: MAX_ANSWER, nodeOptions: { ...target.tls, socketPath: unixPath(target) },
  });
}

function connect(target: Target, path: string, protocol: string,
                 listener: SocketListener): Socket {
  const unix = unixPath(target);
  const url = webUrl(target).replace(/^http/, "ws");
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
    sinkAllBytes(MAX_ANSWER)(response).then(
      (body) => end(LOST, "", httpError(response.statusCode ?? 0, body)), () => end(LOST, ""));
  });
  return socket;
}

export const transport: Transport = {
  defaultUrl: () => "http://127.0.0.1:29473", calls, connect,
  afterMessages: (act) => void setImmediate(act),
};
