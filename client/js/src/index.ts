/** hapticd - the client of hapticd for browsers and Node.
 *
 *   import { Connection, Proxy } from "hapticd";
 *   const server = new Connection("http://127.0.0.1:29473", { token });
 *   const session = await server.open({ clientName: "my simulation", nominalRateHz: 60 });
 *   session.engageWhenReady();
 *   for await (const state of session.states()) {
 *     const x = step(state.xProbe);  // where the objects let the probe be
 *     session.publish(touching ? Proxy.held(x) : Proxy.free());
 *   }
 *
 * Units are SI. An array has one value per degree of freedom or per virtual coordinate, in the
 * order of Device. Messages are those of proto/haptic/v1, with names in camel case; 64-bit integers
 * are bigints. */
export { Connection } from "./connection.js";
export type { ConnectionOptions } from "./connection.js";
export * from "./contact.js";
export { ClientError } from "./errors.js";
export type { Code } from "./errors.js";
export { Proxy, difference, keepDeepest } from "./proxy.js";
export type { Plane, Pose } from "./proxy.js";
export { Session } from "./session.js";
export type { SessionOptions, Settings } from "./session_options.js";
export * from "./solve.js";
export * from "./state_fields.js";
export type { PublishStatistics } from "./statistics.js";
export type { Format } from "./stream.js";
export type { TlsOptions } from "./transport.js";
export type { Vector3 } from "./vectors.js";
export * from "./gen/haptic/v1/drawing_pb.js";
export * from "./gen/haptic/v1/haptic_service_pb.js";
export * from "./gen/haptic/v1/session_pb.js";
