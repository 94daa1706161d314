/** Unary calls: the Connect protocol's unary form (proto/README.md#the-web). */
import { create, fromBinary, fromJsonString, toBinary, toJsonString } from "@bufbuild/protobuf";
import type { DescMessage, MessageInitShape, MessageShape } from "@bufbuild/protobuf";
import { transport } from "#transport";
import { httpError, localError } from "./errors.js";
import type { Format } from "./stream.js";
import type { Target } from "./transport.js";

/** A method of a service; generated descriptors are such. */
export interface Method<I extends DescMessage, O extends DescMessage> {
  parent: { typeName: string };
  name: string;
  input: I;
  output: O;
}

export class Calls {
  constructor(readonly target: Target, readonly format: Format, readonly timeoutMs: number) {}

  /** Rejects with ClientError. */
  async call<I extends DescMessage, O extends DescMessage>(
    method: Method<I, O>, request: MessageInitShape<I>): Promise<MessageShape<O>> {
    const message = create(method.input, request);
    const json = this.format === "json";
    const answer = await transport.post(
      this.target, `/${method.parent.typeName}/${method.name}`,
      json ? "application/json" : "application/proto",
      json ? toJsonString(method.input, message) : toBinary(method.input, message),
      this.timeoutMs);
    if (answer.status !== 200) throw httpError(answer.status, answer.body);
    try {
      return json ? fromJsonString(method.output, new TextDecoder().decode(answer.body),
                                   { ignoreUnknownFields: true })
                  : fromBinary(method.output, answer.body);
    } catch (error) {
      throw localError("internal", `an answer that is none: ${String(error)}`);
    }
  }
}
