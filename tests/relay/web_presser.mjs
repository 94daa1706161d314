// presser.hpp's client on a WebSocket: 100 Hz, asks for force, presses slowly, and asks again if
// force was lost. Its proxy is free until there is force. SIGTERM ends it.
//
//   node web_presser.mjs PACKAGE URL TOKEN REST      REST: rad, of every joint
import { setTimeout as sleep } from "node:timers/promises";
import { pathToFileURL } from "node:url";

const [folder, url, token, rest] = process.argv.slice(2);
const { Connection, DeviceStateName, Proxy } =
  await import(pathToFileURL(`${folder}/dist/index.js`).href);

let session;
process.once("SIGTERM", async () => {
  await session?.close();
  process.exit(0);
});
const server = new Connection(url, { token, timeoutMs: 20000 });
while (session === undefined) {
  session = await server.open({ clientName: "presser", nominalRateHz: 100, reconnect: true,
                                reEngage: true }).catch(() => sleep(100));
}
session.engageWhenReady();

let depth = 0;
setInterval(() => {
  const state = session.state();
  if (state === undefined) return;
  const engaged = state.state === DeviceStateName.ENGAGED;
  depth = engaged ? Math.min(0.15, depth + 0.002) : 0;
  const press = depth * (1 + 0.2 * Math.sin(0.006 * performance.now()));
  const x = engaged ? state.xProbe.map(() => rest - press) : state.xProbe;
  session.publish(state.gain === 0 ? Proxy.free() : Proxy.held(x));
}, 10);
