// The example, and the program in client/README.md, against a running hapticd.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import * as fs from "node:fs";
import * as path from "node:path";
import { test } from "node:test";
import { Hapticd, eventually, open, tokenOf } from "./hapticd_process.mjs";
import { part } from "./package_under_test.mjs";

const { DeviceStateName } = await part("index.js");

/** Runs node in the package; ends with the test. */
function run(t, ...words) {
  const program = spawn(process.execPath, words, { cwd: process.env.HAPTICD_JS });
  program.ended = new Promise((resolve) => program.once("exit", resolve));
  t.after(() => (program.kill("SIGKILL"), program.ended));
  program.said = "";
  for (const out of [program.stdout, program.stderr]) out.on("data", (b) => (program.said += b));
  return program;
}

/** The hand wants 0.52 rad, the wall stands before: the actuator pushes back. */
async function feltAt(t, server) {
  const watcher = await open(t, server.connect("observe"), { role: "observer" });
  return eventually(async () => {
    const state = await watcher.waitForState();
    return state.state === DeviceStateName.ENGAGED && state.tauElastic[0] < -1;
  }, "the wall is felt");
}

test("the wall holds", async (t) => {
  const server = await Hapticd.start(t);
  const example = run(t, "examples/virtual_wall.mjs", server.url, tokenOf("primary"));
  await feltAt(t, server);
  await eventually(() => /ENGAGED, x 0\.\d+, force -\d/.test(example.said), "the example says so");
  example.kill("SIGINT");
  assert.equal(await example.ended, 0, example.said);
  assert.equal((await server.connect().listDevices())[0].controller, "");
});

test("the README's program works", async (t) => {
  const readme = path.join(process.env.HAPTIC_SCENES, "../../client/README.md");
  const code = fs.readFileSync(readme, "utf8").split("```js\n")[1].split("```")[0];
  assert.ok(code.split("\n").length <= 20);
  assert.ok(code.includes('"http://127.0.0.1:29473"'));
  const server = await Hapticd.start(t);
  run(t, "--input-type=module", "-e",
      `const token = ${JSON.stringify(tokenOf("primary"))};` +
      code.replace("http://127.0.0.1:29473", server.url));
  await feltAt(t, server);
});
