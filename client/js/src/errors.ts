/** The one error of the library, from a Connect error or from the close of a session. */
import { ConnectError } from "@connectrpc/connect";
import { codeFromHttpStatus, errorFromJsonBytes } from "@connectrpc/connect/protocol-connect";
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

/** Why a call failed. */
export function callError(error: ConnectError): ClientError {
  const code = CODES[error.code] ?? "unknown";
  const reason = error.findDetails(ErrorInfoSchema)[0]?.reason || code.toUpperCase();
  return new ClientError(code, reason, error.rawMessage);
}

/** The same of an answer to something else than a call: `body` may be a Connect error. */
export function httpError(status: number, body: Uint8Array): ClientError {
  const plain = new ConnectError(`HTTP status ${status}`, codeFromHttpStatus(status));
  try {
    return callError(errorFromJsonBytes(body, undefined, plain));
  } catch {  // not JSON: a proxy's page, for example
    return callError(plain);
  }
}
