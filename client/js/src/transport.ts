/** The difference between a browser and Node: HTTP requests and WebSockets. package.json chooses
 * the module (`#transport`), so that a browser's bundle does not contain Node's. */
import type { Transport as Calls } from "@connectrpc/connect";
import type { ClientError } from "./errors.js";

export interface TlsOptions {
  /** PEM: certificate of the authority that issued the server's; absent: those of the system. */
  ca?: string;
  /** PEM: certificate and private key of this client, if the server asks for them. */
  cert?: string;
  key?: string;
}

export interface Target {
  /** "http://host:port", "https://host:port", or "unix:/path" (Node). */
  readonly url: string;
  readonly token: string | undefined;
  /** Node only: a browser has certificates of its own. */
  readonly tls: TlsOptions | undefined;
}

export const bearer = ({ token }: Target): Record<string, string> =>
  token === undefined ? {} : { "Authorization": `Bearer ${token}` };

/** Events of a socket; `close` comes once and last. */
export interface SocketListener {
  open(): void;
  message(data: string | Uint8Array): void;
  /** `refused`: the server answered the request for a WebSocket with this. A browser hides it. */
  close(code: number, reason: string, refused?: ClientError): void;
}

export interface Socket {
  /** Bytes that wait here for the network. */
  readonly bufferedAmount: number;
  send(data: string | Uint8Array): void;
  close(code: number): void;
}

export interface Transport {
  defaultUrl(): string;
  calls(target: Target, useBinaryFormat: boolean): Calls;
  connect(target: Target, path: string, protocol: string, listener: SocketListener): Socket;
  /** Calls `act` when the messages that are here already were taken. */
  afterMessages(act: () => void): void;
}

/** Largest message of a session (proto/README.md). */
export const MAX_MESSAGE = 65536;
/** Largest answer to a call that is believed. */
export const MAX_ANSWER = 4 << 20;
