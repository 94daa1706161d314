/** The one error of the library, from a Connect error or from the close of a session. */
import { fromBinary } from "@bufbuild/protobuf";
import { base64Decode } from "@bufbuild/protobuf/wire";
import { ErrorInfoSchema } from "./gen/google/rpc/error_details_pb.js";

/** The canonical codes in the order of their numbers, named as Connect names them. */
const CODES = [
  "ok", "canceled", "unknown", "invalid_argument", "deadline_exceeded", "not_found",
  "already_exists", "permission_denied", "resource_exhausted", "failed_precondition", "aborted",
  "out_of_range", "unimplemented", "internal", "unavailable", "data_loss", "unauthenticated",
] as const;
export type Code = (typeof CODES)[number];

/** A call failed, or a session ended. */
export class ClientError extends Error {
  override readonly name = "ClientError";
  constructor(
    readonly code: Code,
    /** For programs: the server's reason, such as "LEASE_HELD" (proto/README.md#errors). If the
     * server gave none, the code in capitals, such as "UNAVAILABLE". */
    readonly reason: string,
    message: string,
  ) {
    super(message);
  }
}

/** An error that this library found itself. */
export function localError(code: Code, message: string): ClientError {
  return new ClientError(code, code.toUpperCase(), message);
}

/** True if another answer may come to those who ask again: a wrong argument stays wrong, a server
 * comes back. PROTOCOL refuses, of what this client sends, only an OpenSession that is late. */
export function mayPass(error: ClientError): boolean {
  return error.reason === "PROTOCOL" ||
    ["unavailable", "deadline_exceeded", "already_exists", "failed_precondition",
      "resource_exhausted", "aborted", "canceled", "ok"].includes(error.code);
}

/** Why the session ended, from the close frame of its WebSocket. */
export function closeError(closeCode: number, text: string): ClientError {
  if (closeCode === 1000) return new ClientError("ok", "CLOSED", text || "the session ended");
  const code = CODES[closeCode - 4000];
  if (code === undefined) {
    return localError("unavailable", text || `the connection was lost (${closeCode})`);
  }
  const [, reason, message] = /^([A-Z][A-Z0-9_]*): ([^]*)$/.exec(text) ?? [];
  return new ClientError(code, reason ?? code.toUpperCase(), message ?? (text || code));
}

const BY_STATUS: Record<number, Code> = {
  400: "internal", 401: "unauthenticated", 403: "permission_denied", 404: "unimplemented",
  429: "unavailable", 502: "unavailable", 503: "unavailable", 504: "unavailable",
};

/** Text of a refused call: `{"code": ..., "message": ..., "details": [...]}`, or, if something
 * else than hapticd answered, the HTTP status. */
export function httpError(status: number, body: Uint8Array): ClientError {
  let said: { code?: unknown; message?: unknown; details?: unknown } = {};
  const text = new TextDecoder().decode(body);
  try {
    said = Object(JSON.parse(text));
  } catch {
    // not JSON: a proxy's page, for example
  }
  const code = CODES.find((known) => known === said.code) ?? BY_STATUS[status] ?? "unknown";
  const message = typeof said.message === "string" ? said.message : `HTTP status ${status}`;
  return new ClientError(code, reasonIn(said.details) ?? code.toUpperCase(), message);
}

function reasonIn(details: unknown): string | undefined {
  for (const detail of Array.isArray(details) ? details : []) {
    if (detail?.type !== "google.rpc.ErrorInfo" || typeof detail.value !== "string") continue;
    try {
      return fromBinary(ErrorInfoSchema, base64Decode(detail.value)).reason || undefined;
    } catch {
      return undefined;
    }
  }
  return undefined;
}
