/** HTTP and WebSockets of a browser. A page that hapticd serves needs no token: it has a cookie. */
import { localError } from "./errors.js";
import type { Answer, Socket, SocketListener, Target, Transport } from "./transport.js";

export const transport: Transport = {
  defaultUrl: () => globalThis.location.origin,

  async post(target, path, type, body, timeoutMs): Promise<Answer> {
    const headers: Record<string, string> = { "Content-Type": type };
    if (target.token !== undefined) headers["Authorization"] = `Bearer ${target.token}`;
    try {
      const response = await fetch(target.url + path, {
        method: "POST", headers, body: body as BodyInit, signal: AbortSignal.timeout(timeoutMs),
      });
      return { status: response.status, body: new Uint8Array(await response.arrayBuffer()) };
    } catch (error) {
      if (error instanceof DOMException && error.name === "TimeoutError") {
        throw localError("deadline_exceeded", `no answer in ${timeoutMs} ms`);
      }
      throw localError("unavailable", `no answer from ${target.url}`);
    }
  },

  afterMessages(act): void {
    const { port1, port2 } = new MessageChannel();  // setTimeout would take 4 ms
    port1.onmessage = () => (port1.close(), act());
    port2.postMessage(null);
  },

  connect(target: Target, path: string, protocol: string, listener: SocketListener): Socket {
    // A browser cannot set headers on a WebSocket.
    const protocols = target.token === undefined ? [protocol]
                                                 : [protocol, `haptic.token.${target.token}`];
    const socket = new WebSocket(target.url.replace(/^http/, "ws") + path, protocols);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => listener.open();
    socket.onmessage = ({ data }) =>
      listener.message(typeof data === "string" ? data : new Uint8Array(data as ArrayBuffer));
    socket.onclose = ({ code, reason }) => listener.close(code, reason);
    return socket as Socket;
  },
};
