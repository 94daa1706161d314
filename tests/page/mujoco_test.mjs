// The page mujoco.html of a running hapticd, against haptic-example-mujoco with the same device,
// motion and model: how strong the force is, how long a frame keeps a core, and what the page says
// and shows. By the clock a frame takes longer, because Chromium paints by software on the same
// cores: that is reported. With $HAPTIC_CALM, on a machine that does nothing else, it judges what a
// busy machine changes: how long a frame keeps a core, and how far the forces are from the native
// client's. Without it, the ball must be felt, by samples in time, with at least half of that
// force.
//
//   ctest --preset release -R page.mujoco_calm -V      prints these figures
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import * as fs from "node:fs";
import * as path from "node:path";
import { test } from "node:test";
import { open } from "../client/js/hapticd_process.mjs";
import {
  coloursOf, eventually, fitsAcross, newPage, PHONE, says, startBrowser, violations,
} from "./browser.mjs";
import { printedAddress, startHapticd } from "./live_server.mjs";
import { workerTimes } from "./worker_time.mjs";

const WITHIN = 0.05;    // of the native client's force
const LONGEST_MS = 8;   // physics and publishing of a frame
const CALM = process.env.HAPTIC_CALM !== undefined;
const scene = { scene: "finger_soft_grasp" };
const PICTURE = process.env.HAPTIC_PICTURE ?? "mujoco.png";
const NATIVE = process.env.HAPTIC_EXAMPLE_MUJOCO, MODELS = process.env.HAPTIC_MUJOCO_MODELS;

/** The simulated hand is open for 5 s, presses the ball, then the box too, and opens. */
function motion(folder) {
  const ball = [0.85, 0.05], both = [0.95, 0.95], open = 0.1;
  const rise = (t, from, took) =>
    0.5 - 0.5 * Math.cos(Math.PI * Math.min(Math.max((t - from) / took, 0), 1));
  const rows = Array.from({ length: 1201 }, (_, i) => {
    const t = i / 100, end = rise(t, 10.2, 0.5);
    const first = rise(t, 5, 0.7), second = rise(t, 7.7, 0.5);
    return [t, ...[0, 1].map((k) => {
      const closed = open + (ball[k] - open) * first + (both[k] - ball[k]) * second;
      return closed + (open - closed) * end;
    })].join(",");
  });
  const file = path.join(folder, "motion.csv");
  fs.writeFileSync(file, ["time_s,q_o1_mcp_rad,q_o2_pip_rad", ...rows].join("\n") + "\n");
  return file;
}

/** Median force, N, while the next grasp holds the ball, and then the box too. */
async function forcesOfGrasp(watch) {
  const held = [{ from: 1.2, to: 2.2, forces: [] }, { from: 3.2, to: 4.7, forces: [] }];
  for (let begin, at = 0; at < held.at(-1).to;) {
    const { tauA: [force], serverTimeNs, gain } = await watch.waitForState();
    if (Math.abs(force) > 0.02) begin ??= serverTimeNs;
    at = begin === undefined ? 0 : Number(serverTimeNs - begin) * 1e-9;
    if (gain < 1) continue;  // its sample is late
    held.find(({ from, to }) => at > from && at < to)?.forces.push(Math.abs(force));
  }
  return held.map(({ forces }) => forces.sort((a, b) => a - b)[forces.length >> 1]);
}

async function handOpens(watch) {
  for (let closed = false;;) {
    const { xProbe: [flexion] } = await watch.waitForState();
    closed ||= flexion > 0.6;
    if (closed && flexion < 0.12) return;
  }
}

/** Until four of five motors press at once: the grasp of the ball. */
async function handPresses(watch) {
  for (;;) {
    const { tauA } = await watch.waitForState();
    if (tauA.filter((force) => Math.abs(force) > 0.5).length >= 4) return;
  }
}

/** Share of a core that the worker takes for a frame, until `over` is kept. */
async function frameOfCore(over) {
  const computed = await workerTimes(over);
  await over;
  assert.ok(computed.length > (CALM ? 100 : 10));  // a busy machine computes fewer frames
  const [half, most] = [0.5, 0.99].map(
    (part) => computed[Math.floor(part * (computed.length - 1))]);
  assert.ok(!CALM || most <= LONGEST_MS, `${most} ms of a core`);
  return `${half.toFixed(1)} ms, 99 % within ${most.toFixed(1)} ms`;
}

async function openMujoco(t, browser, server, options = {}) {
  const opened = await newPage(t, browser, options), { page } = opened;
  await page.goto(await printedAddress(server));
  await page.goto(new URL("/mujoco.html", page.url()).href);
  return opened;
}

test("a MuJoCo scene in the browser", { timeout: 600000 }, async (t) => {
  const folder = fs.mkdtempSync(path.join(process.env.TMPDIR ?? "/tmp", "haptic-mujoco-"));
  t.after(() => fs.rmSync(folder, { recursive: true }));
  const settings = [`device[0].simulated_finger.motion_file="${motion(folder)}"`];
  const browser = await startBrowser(t);

  await t.test("is felt as strong as natively", async (t) => {
    const server = await startHapticd(t, "control", { ...scene, settings });
    const watch = await open(t, server.connect("observe"), { role: "observer", stateRateHz: 200 });
    const { page, complaints } = await openMujoco(t, browser, server);
    await page.click("#start");
    await says(page, "#timing", /frames$/);
    await says(page, "#state", /^Ready\. Press Force on\./);
    await page.click("#engage");
    await says(page, "#state", /^Force is on/);
    await handOpens(watch);
    await page.click("#reset");
    const grasp = forcesOfGrasp(watch), ofCore = await frameOfCore(grasp), forces = await grasp;
    await says(page, "#pushed", /The box has moved by \d+ mm/);
    await says(page, "#touch", /^You touch the (ball|box)( and the box)?\.$/);
    const [timing, painted] = await page.evaluate(
      () => ["timing", "painted"].map((id) => document.getElementById(id).textContent));
    console.log(`a frame ${timing}; of a core ${ofCore}; ${painted}`);
    await page.screenshot({ path: PICTURE, fullPage: true });
    assert.ok(await coloursOf(page, "#picture") > 50, "the picture is blank");
    assert.deepEqual(await violations(page), []);
    assert.deepEqual(complaints.filter((text) => !/GPU stall|WebGL/.test(text)), []);
    await page.click("#release");
    await says(page, "#state", /^(Ready|Waiting)/);
    await page.click("#stop");
    await says(page, "#state", /^Stopped/);
    assert.ok(await page.locator("#fault a[href='./']").isVisible());
    await page.click("#engage");
    await says(page, "#state", /^Stopped by a fault\. No force yet: .*FAULT/);
    await page.close();
    if (!NATIVE || !fs.existsSync(NATIVE)) return t.diagnostic("no native client to compare with");

    const other = await startHapticd(t, "control", { ...scene, settings });
    const reference = await open(t, other.connect("observe"),
                                 { role: "observer", stateRateHz: 200 });
    const client = spawn(NATIVE, [`${MODELS}/finger.xml`, "--server", `unix:${other.folder}/grpc`],
                         { stdio: "ignore" });
    t.after(() => client.kill());
    const expected = await forcesOfGrasp(reference);
    console.log(`ball, then box too: ${forces} N, natively ${expected} N`);
    const [ball, both] = expected.map((force, i) => Math.abs(forces[i] - force) / force);
    assert.ok(ball <= (CALM ? WITHIN : 0.5));
    if (CALM) assert.ok(both <= WITHIN);
  });

  await t.test("is felt by a whole hand", async (t) => {
    const server = await startHapticd(t, "control", { scene: "hand_soft_grasp" });
    const watch = await open(t, server.connect("observe"), { role: "observer", stateRateHz: 60 });
    const { page, complaints } = await openMujoco(t, browser, server);
    await eventually(page, () => document.getElementById("model").value === "hand");
    await page.click("#start");
    await says(page, "#timing", /frames$/);
    await page.click("#engage");
    await says(page, "#state", /^Force is on/);
    await page.selectOption("#model", "finger");  // does not end the force
    await page.click("#start");
    await says(page, "#said", /not for this device/);
    await says(page, "#state", /^Force is on/);
    const ofCore = await frameOfCore(handPresses(watch)
      .then(() => says(page, "#pushed", /The box has moved by \d+ mm/)));
    const timing = await page.evaluate(() => document.getElementById("timing").textContent);
    console.log(`a frame of the hand ${timing}; of a core ${ofCore}`);
    await page.screenshot({ path: PICTURE.replace(/\.png$/, "-hand.png"), fullPage: true });
    assert.deepEqual(complaints.filter((text) => !/GPU stall|WebGL/.test(text)), []);
  });

  await t.test("is explained to a key that may only look", async (t) => {
    const server = await startHapticd(t, "observe", scene);
    const { page } = await openMujoco(t, browser, server, PHONE);
    await page.click("#start");
    await says(page, "#said", /may only look/);
    await says(page, "#state", /^Not started\.$/);
    await fitsAcross(page);
    assert.deepEqual(await violations(page), []);
  });

  await t.test("is found from the page", async (t) => {
    const server = await startHapticd(t, "control", scene);
    const { page } = await newPage(t, browser);
    await page.goto(await printedAddress(server));
    await page.click("a[href='mujoco.html']");
    await says(page, "h2", /Touch things/);
  });
});
