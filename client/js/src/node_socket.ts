/** A WebSocket client on Node's HTTP upgrade (RFC 6455), without extensions: Node 18 has none. A
 * message has at most MAX_MESSAGE bytes, and the server has CLOSE_MS to answer a close frame. */
import { createHash, randomBytes } from "node:crypto";
import type { ClientRequest, IncomingMessage, OutgoingHttpHeaders } from "node:http";
import type { Duplex } from "node:stream";
import type { ClientError } from "./errors.js";
import { MAX_MESSAGE } from "./transport.js";
import type { Socket, SocketListener } from "./transport.js";

const enum Opcode { CONTINUATION, TEXT, BINARY, CLOSE = 8, PING, PONG }

const CLOSE_MS = 2000;
const LOST = 1006, PROTOCOL_ERROR = 1002, NOT_UTF8 = 1007, TOO_LARGE = 1009;
const GUID = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";  // RFC 6455, section 1.3

/** The frame of one whole message, masked; throws if it has 64 KB or more. */
export function encodeFrame(opcode: number, payload: Uint8Array, mask = randomBytes(4)): Buffer {
  const long = payload.length > 125;
  const begin = long ? 8 : 6;
  const frame = Buffer.alloc(begin + payload.length);
  frame[0] = 0x80 | opcode;
  frame[1] = 0x80 | (long ? 126 : payload.length);
  if (long) frame.writeUInt16BE(payload.length, 2);
  frame.set(mask, begin - 4);
  for (let i = 0; i < payload.length; ++i) frame[begin + i] = payload[i]! ^ mask[i & 3]!;
  return frame;
}

/** Refused: what the server sent is against the protocol. */
export class FrameError extends Error {
  constructor(readonly closeCode: number, message: string) {
    super(message);
  }
}

export interface Frame {
  final: boolean;
  opcode: number;
  payload: Buffer;
}

/** Cuts the server's bytes into frames; keeps what is not a whole frame yet. */
export class FrameReader {
  // Bytes that are kept; room behind them grows twofold, so that bytes may come singly. Nothing is
  // written twice: payloads are views.
  #bytes: Buffer = Buffer.alloc(0);
  #begin = 0;
  #end = 0;

  *read(chunk: Buffer): Generator<Frame> {
    this.#append(chunk);
    for (let frame = this.#next(); frame !== undefined; frame = this.#next()) yield frame;
  }

  #append(chunk: Buffer): void {
    const kept = this.#end - this.#begin;
    if (kept === 0 || this.#end + chunk.length > this.#bytes.length) {
      const before = this.#bytes.subarray(this.#begin, this.#end);
      this.#bytes = kept === 0 ? chunk : Buffer.alloc(2 * (kept + chunk.length));
      this.#bytes.set(before);
      this.#begin = 0;
      this.#end = kept;
    }
    if (kept > 0) this.#bytes.set(chunk, this.#end);
    this.#end += chunk.length;
  }

  #next(): Frame | undefined {
    const bytes = this.#bytes.subarray(this.#begin, this.#end);
    if (bytes.length < 2) return undefined;
    const [first, second] = [bytes[0]!, bytes[1]!];
    const opcode = first & 0x0f, final = (first & 0x80) !== 0, control = opcode >= Opcode.CLOSE;
    if ((first & 0x70) !== 0 || (second & 0x80) !== 0 ||
        (opcode > Opcode.BINARY && !control) || opcode > Opcode.PONG) {
      throw new FrameError(PROTOCOL_ERROR, "a frame that is masked or unknown");
    }
    if (control && (!final || second > 125)) {
      throw new FrameError(PROTOCOL_ERROR, "a control frame that is cut or too long");
    }
    const begin = second === 127 ? 10 : second === 126 ? 4 : 2;
    if (bytes.length < begin) return undefined;
    const length = begin === 10 ? Number(bytes.readBigUInt64BE(2))
                                : begin === 4 ? bytes.readUInt16BE(2) : second;
    if (length > MAX_MESSAGE) throw new FrameError(TOO_LARGE, "a message of more than 64 KB");
    if (bytes.length < begin + length) return undefined;
    this.#begin += begin + length;
    return { final, opcode, payload: bytes.subarray(begin, begin + length) };
  }
}

export class NodeSocket implements Socket {
  #stream: Duplex | undefined;
  #request: ClientRequest;
  #reader = new FrameReader();
  #parts: Buffer[] = [];  // of a message that came in several frames
  #opcode = 0;            // of that message; 0: none
  #size = 0;
  #said: { code: number; reason: string } | undefined;  // by the first close frame
  #closing = false;       // a close frame was sent
  #closed = false;

  /** `begin` sends the request; `refused` reads an answer that is no upgrade. */
  constructor(begin: (headers: OutgoingHttpHeaders) => ClientRequest, protocol: string,
              private readonly listener: SocketListener,
              refused: (response: IncomingMessage) => Promise<ClientError>) {
    const key = randomBytes(16).toString("base64");
    this.#request = begin({
      "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
      "Sec-WebSocket-Key": key, "Sec-WebSocket-Protocol": protocol,
    });
    this.#request.on("error", (error) => this.#end(LOST, error.message));
    this.#request.on("response", (response) => {
      refused(response).then((why) => this.#end(LOST, "", why), () => this.#end(LOST, ""));
    });
    this.#request.on("upgrade", (response, stream, head) => {
      const accept = createHash("sha1").update(key + GUID).digest("base64");
      if (response.headers["sec-websocket-accept"] !== accept ||
          response.headers["sec-websocket-protocol"] !== protocol ||
          response.headers["sec-websocket-extensions"] !== undefined) {
        stream.destroy();
        return this.#end(LOST, "the answer to the upgrade is not the one that was asked for");
      }
      this.#begin(stream, head);
    });
    this.#request.end();
  }

  get bufferedAmount(): number {
    return this.#stream?.writableLength ?? 0;
  }

  send(data: string | Uint8Array): void {
    const text = typeof data === "string";
    this.#write(text ? Opcode.TEXT : Opcode.BINARY, text ? Buffer.from(data) : data);
  }

  close(code = 1000, reason = ""): void {
    if (this.#stream === undefined) {
      this.#request.destroy();
      return this.#end(code, reason);
    }
    if (this.#closing || this.#closed) return;
    const payload = Buffer.alloc(2 + Buffer.byteLength(reason));
    payload.writeUInt16BE(code, 0);
    payload.write(reason, 2);
    this.#write(Opcode.CLOSE, payload);
    this.#closing = true;
    this.#said ??= { code, reason };
    setTimeout(() => this.#stream?.destroy(), CLOSE_MS).unref();
  }

  #begin(stream: Duplex, head: Buffer): void {
    this.#stream = stream;
    if ("setNoDelay" in stream) (stream.setNoDelay as (on: boolean) => void)(true);
    stream.on("error", () => undefined);  // "close" follows
    stream.on("close", () => this.#end(this.#said?.code ?? LOST, this.#said?.reason ?? ""));
    stream.on("end", () => stream.end());
    this.listener.open();
    const take = (chunk: Buffer): void => {
      try {
        for (const frame of this.#reader.read(chunk)) this.#take(frame);
      } catch (error) {
        if (!(error instanceof FrameError)) throw error;
        this.close(error.closeCode, error.message);
        stream.destroy();
      }
    };
    if (head.length > 0) take(head);
    stream.on("data", take);
  }

  #take({ final, opcode, payload }: Frame): void {
    if (this.#closing && opcode !== Opcode.CLOSE) return;
    if (opcode === Opcode.PING) return this.#answer(payload);
    if (opcode === Opcode.PONG) return;
    if (opcode === Opcode.CLOSE) return this.#takeClose(payload);
    if ((opcode === Opcode.CONTINUATION) === (this.#opcode === 0)) {
      throw new FrameError(PROTOCOL_ERROR, "frames of a message out of order");
    }
    if (opcode !== Opcode.CONTINUATION) this.#opcode = opcode;
    this.#size += payload.length;
    if (this.#size > MAX_MESSAGE || this.#parts.push(payload) > 1024) {
      throw new FrameError(TOO_LARGE, "a message of more than 64 KB");
    }
    if (!final) return;
    const message = this.#parts.length > 1 ? Buffer.concat(this.#parts) : payload;
    const text = this.#opcode === Opcode.TEXT;
    this.#parts = [];
    this.#opcode = this.#size = 0;
    this.listener.message(text ? decodeText(message) : message);
  }

  /** A server that sends pings and reads no answers does not fill this end's memory. */
  #answer(ping: Buffer): void {
    if (this.bufferedAmount < MAX_MESSAGE) this.#write(Opcode.PONG, ping);
  }

  #takeClose(payload: Buffer): void {
    const code = payload.length >= 2 ? payload.readUInt16BE(0) : 1005;
    this.#said = { code, reason: payload.subarray(2).toString() };
    this.close(payload.length >= 2 ? code : 1000);
    this.#stream?.end();
  }

  #write(opcode: number, payload: Uint8Array): void {
    if (!this.#closing && !this.#closed) this.#stream?.write(encodeFrame(opcode, payload));
  }

  #end(code: number, reason: string, refused?: ClientError): void {
    if (this.#closed) return;
    this.#closed = true;
    this.listener.close(code, reason, refused);
  }
}

function decodeText(bytes: Buffer): string {
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    throw new FrameError(NOT_UTF8, "a text that is not UTF-8");
  }
}
