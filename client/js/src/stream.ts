/** One WebSocket of a session: messages up and down, and of the samples only the newest. */
import { create, fromBinary, fromJsonString, toBinary, toJsonString } from "@bufbuild/protobuf";
import type { MessageInitShape } from "@bufbuild/protobuf";
import { transport } from "#transport";
import { ClientError, closeError, localError } from "./errors.js";
import { SessionRequestSchema, SessionResponseSchema } from "./gen/haptic/v1/session_pb.js";
import type { SessionResponse } from "./gen/haptic/v1/session_pb.js";
import type { Socket, Target } from "./transport.js";

/** How messages are written: protobuf's bytes, or its JSON. */
export type Format = "binary" | "json";
export type Request = NonNullable<MessageInitShape<typeof SessionRequestSchema>["message"]>;

const PATH = "/haptic.v1.HapticService/Session";
/** States come at least once a second: two of these without a message, and the network is gone. */
const SILENCE_MS = 2500;
/** A sample that waits for the network looks so often whether it can go. */
const LOOK_MS = 4;

export interface StreamListener {
  message(response: SessionResponse["message"]): void;
  /** A sample was handed to the network; `replaced` gave way to it before. */
  sent(replaced: number): void;
  /** Once, and nothing after it. */
  end(why: ClientError): void;
}

export class Stream {
  #socket: Socket;
  #open = false;
  #over = false;
  #waiting: string | Uint8Array | undefined;
  #replaced = 0;
  #look: ReturnType<typeof setTimeout> | undefined;
  #watch: ReturnType<typeof setInterval> | undefined;
  #silent = 0;
  readonly #ended: Promise<void>;

  /** Sends `opening` as the first message. */
  constructor(target: Target, private readonly format: Format, opening: Request,
              private readonly listener: StreamListener) {
    let resolve: () => void = () => undefined;
    this.#ended = new Promise((done) => (resolve = done));
    const protocol = format === "json" ? "haptic.v1.json" : "haptic.v1.proto";
    this.#socket = transport.connect(target, PATH, protocol, {
      open: () => {
        if (this.#over) return;
        this.#open = true;
        this.#watch = setInterval(() => this.#expectMessage(), SILENCE_MS);
        this.#socket.send(this.#encode(opening));
      },
      message: (data) => this.#take(data),
      close: (code, reason, refused) => {
        const opened = this.#open;
        this.#end(refused ?? (opened || code !== 1006 ? closeError(code, reason) : localError(
          "unavailable", `no session at ${target.url}: ${reason || "no server, or it refused"}`)));
        resolve();
      },
    });
  }

  /** Sends a sample now, or keeps it until the network takes it or a newer one comes. Throws if it
   * cannot be written. */
  offer(sample: Request): void {
    if (this.#over || !this.#open) return;
    const data = this.#encode(sample);
    if (this.#waiting !== undefined) ++this.#replaced;
    this.#waiting = data;
    this.#flush();
  }

  /** Says farewell, after which the server ends the stream; waits for that, or `ms`. */
  async leave(ms: number): Promise<void> {
    this.#waiting = undefined;
    if (!this.#open || this.#over) return;
    this.#socket.send(this.#encode({ case: "leave", value: {} }));
    let timer: ReturnType<typeof setTimeout> | undefined;
    await Promise.race([this.#ended, new Promise((done) => (timer = setTimeout(done, ms)))]);
    clearTimeout(timer);
  }

  cancel(why: ClientError): void {
    this.#end(why);
    this.#socket.close(1000);
  }

  #flush(): void {
    clearTimeout(this.#look);
    this.#look = undefined;
    if (this.#waiting === undefined || this.#over) return;
    if (this.#socket.bufferedAmount > 0) {
      this.#look = setTimeout(() => this.#flush(), LOOK_MS);
      return;
    }
    const sample = this.#waiting;
    const replaced = this.#replaced;
    this.#waiting = undefined;
    this.#replaced = 0;
    this.#socket.send(sample);
    this.listener.sent(replaced);
  }

  #encode(message: Request): string | Uint8Array {
    const request = create(SessionRequestSchema, { message });
    return this.format === "json" ? toJsonString(SessionRequestSchema, request)
                                  : toBinary(SessionRequestSchema, request);
  }

  #take(data: string | Uint8Array): void {
    if (this.#over) return;
    this.#silent = 0;
    let response: SessionResponse;
    try {
      response = typeof data === "string"
        ? fromJsonString(SessionResponseSchema, data, { ignoreUnknownFields: true })
        : fromBinary(SessionResponseSchema, data);
    } catch (error) {
      return this.cancel(localError("internal", `an answer that is none: ${String(error)}`));
    }
    this.listener.message(response.message);
    this.#flush();
  }

  #expectMessage(): void {
    if (++this.#silent > 1) this.cancel(localError("unavailable", "the server fell silent"));
  }

  #end(why: ClientError): void {
    if (this.#over) return;
    this.#over = true;
    clearTimeout(this.#look);
    clearInterval(this.#watch);
    this.listener.end(why);
  }
}
