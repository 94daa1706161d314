// The page mujoco.html of a running hapticd, against haptic-example-mujoco with the same device,
// motion and model: how strong the force is, and how long a frame takes.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import * as fs from "node:fs";
import { test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { open } from "../client/js/hapticd_process.mjs";
import { coloursOf, newPage, says, startBrowser } from "./browser.mjs";
import { printedAddress, startHapticd } from "./live_server.mjs";

const MOTION_S = 20;      // two repetitions of the recorded one
const LONGEST_MS = 8;     // physics and publishing of a frame
const WITHIN = 0.05;      // of the native client's force
const scene = { scene: "finger_soft_grasp" };
const NATIVE = process.env.HAPTIC_EXAMPLE_MUJOCO, MODELS = process.env.HAPTIC_MUJOCO_MODELS;

/** The largest force of each motor during the motion. */
async function largestForces(t, server) {
  const watch = await open(t, server.connect("observe"), { role: "observer", stateRateHz: 500 });
  const most = [];
  for (const end = Date.now() + MOTION_S * 1000; Date.now() < end;) {
    const { tauA } = await watch.waitForState();
    tauA.forEach((force, i) => (most[i] = Math.max(most[i] ?? 0, Math.abs(force))));
  }
  return most;
}

async function native(t) {
  const server = await startHapticd(t, "control", scene);
  const client = spawn(NATIVE, [`${MODELS}/finger.xml`, "--server", `unix:${server.folder}/grpc`],
                       { stdio: "ignore" });
  t.after(() => client.kill());
  await sleep(2000);
  const forces = await largestForces(t, server);
  client.kill();
  await server.end();
  return forces;
}

test("a MuJoCo scene in the browser", async (t) => {
  const browser = await startBrowser(t);

  await t.test("is felt", async (t) => {
    const server = await startHapticd(t, "control", scene);
    const { page, complaints } = await newPage(t, browser);
    await page.goto(await printedAddress(server));
    await page.goto(new URL("/mujoco.html", page.url()).href);
    await page.click("#start");
    await says(page, "#timing", /frames$/);
    assert.deepEqual(complaints.filter((text) => !/GPU stall|WebGL/.test(text)), []);
    await page.click("#engage");
    await says(page, "#state", /^ENGAGED/);
    const forces = await largestForces(t, server);
    await page.screenshot({ path: process.env.HAPTIC_PICTURE ?? "mujoco.png" });
    assert.ok(await coloursOf(page, "#picture") > 50, "the picture is blank");
    const [timing, painted] = await page.evaluate(
      () => ["timing", "painted"].map((id) => document.getElementById(id).textContent));
    await page.click("#reset");
    await says(page, "#state", /ENGAGED$/);
    await page.click("#release");
    await says(page, "#state", /^(ARMED|IDLE)/);
    await page.close();
    await server.end();
    console.log(`browser ${forces} N; a frame ${timing}; ${painted}`);
    const p99 = Number(/within ([\d.]+) ms/.exec(timing)[1]);
    if (process.env.HAPTIC_CALM) assert.ok(p99 <= LONGEST_MS, timing);
    if (!NATIVE || !fs.existsSync(NATIVE)) return t.diagnostic("no native client to compare with");
    const expected = await native(t);
    console.log(`native ${expected} N`);
    expected.forEach((force, i) => assert.ok(Math.abs(forces[i] - force) <= WITHIN * force,
                                             `motor ${i}: ${forces[i]} N, natively ${force} N`));
  });

  await t.test("is explained to a key that may only look", async (t) => {
    const server = await startHapticd(t, "observe", scene);
    const { page } = await newPage(t, browser);
    await page.goto(await printedAddress(server));
    await page.goto(new URL("/mujoco.html", page.url()).href);
    await page.click("#start");
    await says(page, "#said", /may only look/);
  });
});
