// The JavaScript client in lock-step: does what stdin says, a line each, and answers with a line.
//
//   node lock_step_client.mjs PACKAGE URL FORMAT
//   free | held X... | engage | state      (state: its seq and tau_a)
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

const [folder, url, format] = process.argv.slice(2);
const { Connection, Proxy } = await import(pathToFileURL(`${folder}/dist/index.js`).href);

/** Answers "0 ", and what `act` says; or "1 ", and what went wrong. */
async function answer(act) {
  try {
    console.log(`0 ${await act() ?? ""}`);
  } catch (error) {
    console.log(`1 ${error.message}`);
  }
}

let session;
await answer(async () => {
  session = await new Connection(url, { format }).open({ clientName: "in JavaScript",
    nominalRateHz: 100, stateRateHz: 0 });
});
for await (const line of createInterface({ input: process.stdin })) {
  const [what, ...numbers] = line.split(" ");
  await answer(() => {
    if (what === "free") session.publish(Proxy.free());
    if (what === "held") session.publish(Proxy.held(numbers.map(Number)));
    if (what === "engage") return session.engage();
    if (what === "state") return `${session.state().seq} ${session.state().tauA[0]}`;
  });
}
