/** HTTP and WebSockets of a browser. A page that hapticd serves needs no token: it has a cookie. */
import { createConnectTransport } from "@connectrpc/connect-web";
import type { Socket, SocketListener, Target, Transport } from "./transport.js";

export const transport: Transport = {
  defaultUrl: () => globalThis.location.origin,

  calls: ({ url }, useBinaryFormat) => createConnectTransport({ baseUrl: url, useBinaryFormat }),

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
