// A wall in joint space: the first virtual coordinate may not pass 0.314 rad (18 degrees). The wall
// is a plane, so the server keeps the probe behind it at 1 kHz, and force may begin beyond it.
//
//   node virtual_wall.mjs [URL [TOKEN]]

import { Connection, Proxy, enumName, DeviceStateNameSchema } from "hapticd";

const [url, token] = process.argv.slice(2);
const server = new Connection(url, { token });
const session = await server.open({
  clientName: "virtual wall",
  nominalRateHz: 200,
  reEngage: true,
  onEvent: (event) => console.log(`${event.reason}: ${event.message}`),
});
process.once("SIGINT", () => session.close());
session.engageWhenReady();

const normal = session.device.coordinates.map((_, i) => (i === 0 ? 1 : 0));
let shown = 0;
for await (const state of session.states()) {
  session.publish(Proxy.behind([{ normal, offset: 0.314 }], state.xProbe));
  if (++shown % 200 === 0) {
    const [x, force] = [state.xProbe[0].toFixed(3), state.tauElastic[0].toFixed(2)];
    console.log(`${enumName(DeviceStateNameSchema, state.state)}, x ${x}, force ${force}`);
  }
}
