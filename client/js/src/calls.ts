/** Unary calls: the Connect protocol's unary form (proto/README.md#the-web). */
import type {
  DescMessage, DescMethodUnary, MessageInitShape, MessageShape,
} from "@bufbuild/protobuf";
import { ConnectError } from "@connectrpc/connect";
import type { Transport } from "@connectrpc/connect";
import { transport } from "#transport";
import { callError, localError } from "./errors.js";
import type { Format } from "./stream.js";
import { bearer } from "./transport.js";
import type { Target } from "./transport.js";

export class Calls {
  readonly #calls: Transport;

  constructor(readonly target: Target, readonly format: Format, readonly timeoutMs: number) {
    this.#calls = transport.calls(target, format === "binary");
  }

  /** Rejects with ClientError. */
  async call<I extends DescMessage, O extends DescMessage>(
    method: DescMethodUnary<I, O>, request: MessageInitShape<I>): Promise<MessageShape<O>> {
    const { target, timeoutMs } = this, late = AbortSignal.timeout(timeoutMs);
    try {
      return (await this.#calls.unary(method, late, undefined, bearer(target), request)).message;
    } catch (error) {
      if (late.aborted) throw localError("deadline_exceeded", `no answer in ${timeoutMs} ms`);
      const why = ConnectError.from(error);
      if (why.cause === undefined) throw callError(why);
      throw localError("unavailable", `no answer from ${target.url}: ${why.rawMessage}`);
    }
  }
}
