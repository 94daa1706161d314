// The page of a running hapticd: by its printed address, under its policy, with real devices.
import assert from "node:assert/strict";
import * as fs from "node:fs";
import * as os from "node:os";
import * as path from "node:path";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { PHONE, coloursOf, fitsAcross, newPage, says, startBrowser, violations }
  from "./browser.mjs";
import { holdDevice, printedAddress, selfSigned, startHapticd } from "./live_server.mjs";

const LARGEST_GZIPPED = 400e3;

/** A page that came by the printed address. */
async function visit(t, browser, server, options) {
  const opened = await newPage(t, browser, options);
  await opened.page.goto(await printedAddress(server));
  return opened;
}

test("the page is small", () => {
  const folder = process.env.HAPTIC_PAGE;
  const sizes = fs.readdirSync(folder, { withFileTypes: true })
    .filter((entry) => entry.isFile()).map(({ name }) => name)  // not the folder of mujoco.html
    .map((name) => gzipSync(fs.readFileSync(path.join(folder, name))).length);
  const sum = sizes.reduce((a, b) => a + b);
  console.log(`${sum} bytes gzipped`);
  assert.ok(sum < LARGEST_GZIPPED);
});

test("the page of a hapticd", async (t) => {
  const browser = await startBrowser(t);

  await t.test("shows and stops, without complaint", async (t) => {
    const server = await startHapticd(t, "control");
    const { page, complaints } = await visit(t, browser, server);
    assert.equal(new URL(page.url()).search, "", "the token stays in the address");
    await says(page, "#state-title", /^Waiting$/);
    await says(page, "#scene", /one finger at rest/);
    await says(page, "#joints", /mm/);
    await holdDevice(t, server);
    await says(page, "#state-title", /^Force is on$/);
    await says(page, "#controller", /simulation/);
    await says(page, "#sessions", /simulation controls the device/);
    await says(page, "#trace-age .value", /ms$/);
    await says(page, "#events", /Force is on/);
    await says(page, "#grid-size", /mm$/);
    await page.waitForTimeout(1500);
    assert.ok(await coloursOf(page, "#picture") > 100, "the picture is blank");
    assert.deepEqual(await violations(page), []);

    await page.click("#stop");
    await says(page, "#stop-said", /^Stopped finger in/);
    await says(page, "#state-name", /^FAULT$/);
    await says(page, "#faults", /Emergency stop/);
    await page.click("#clear");
    await says(page, "#action-said", /^Fault cleared/);
    await says(page, "#state-name", /^(IDLE|ARMED)$/);
    assert.deepEqual(complaints, []);
  });

  await t.test("an observer stops and clears not", async (t) => {
    const server = await startHapticd(t, "observe");
    const { page, complaints } = await visit(t, browser, server, PHONE);
    await says(page, "#state-title", /^Waiting$/);
    await fitsAcross(page);
    await page.tap("#stop");
    await says(page, "#faults", /Emergency stop/);
    await says(page, "#clear-why", /looking and stopping only/);
    assert.ok(await page.locator("#clear").isDisabled());
    assert.deepEqual(await violations(page), []);
    assert.deepEqual(complaints, []);
    // With the token of a person in charge it clears.
    await page.click("#other-key");
    await page.fill("#token", "operator-token-of-a-test");
    await page.keyboard.press("Enter");
    await page.click("#clear");
    await says(page, "#state-name", /^IDLE$/);
  });

  await t.test("a higher rank releases", async (t) => {
    const server = await startHapticd(t, "control");
    const { page } = await visit(t, browser, server);
    const session = await holdDevice(t, server);
    await says(page, "#state-title", /^Force is on$/);
    await page.click("#release");
    await says(page, "#action-said", /same rank/);
    assert.ok(session.state().gain > 0);
    await page.click("#other-key");
    await page.fill("#token", "operator-token-of-a-test");
    await page.keyboard.press("Enter");
    await says(page, "#action-said", /^$/);  // the refusal goes when the page has the new key
    await page.click("#release");
    await says(page, "#action-said", /^Force released/);
    await says(page, "#gain-value", /^0 %$/);
    await says(page, "#faults", /^$/);
  });

  await t.test("a printed address works once", async (t) => {
    const server = await startHapticd(t, "observe");
    const address = await printedAddress(server);
    const { page } = await newPage(t, browser);
    await page.goto(address);
    await says(page, "#connection", /^Live/);
    await page.reload();
    await says(page, "#connection", /^Live/);
    const { page: other } = await newPage(t, browser);
    await other.goto(address);
    await says(other, "#access", /one-time token/);
    await other.goto(await printedAddress(server));
    await says(other, "#connection", /^Live/);
  });

  await t.test("a certificate of one's own is enough", async (t) => {
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), "haptic-page-"));
    t.after(() => fs.rmSync(folder, { recursive: true }));
    const server = await startHapticd(t, "observe", { settings: [selfSigned(folder)] });
    const address = await printedAddress(server);
    assert.equal(new URL(address).protocol, "https:");
    const { page: wary } = await newPage(t, browser);
    await assert.rejects(wary.goto(address), /ERR_CERT_AUTHORITY_INVALID/);
    // The browser behaves as if the person said "proceed".
    const { page, complaints } = await newPage(t, browser, { ignoreHTTPSErrors: true });
    await page.goto(address);
    await says(page, "#connection", /^Live/);
    await page.reload();
    await says(page, "#connection", /^Live/);
    await page.click("#stop");
    await says(page, "#stop-said", /^Stopped finger in/);
    await says(page, "#state-name", /^FAULT$/);
    assert.deepEqual(complaints, []);
  });

  await t.test("one page shows several devices", async (t) => {
    const server = await startHapticd(t, "observe", { settings: [
      `device[1]={name: "rail" simulated_linear {mass: 0.15 damping: 1 max_effort: 20} ` +
      `linear {dof {name: "s" unit: "m" actuated: true lower: -0.1 upper: 0.1} ` +
      `coordinate {name: "s" unit: "m"} A: 1} limits {force_n: 10} ` +
      `impedance {stiffness_n_per_m: 500 damping_n_s_per_m: 0.2}}`] });
    const { page, complaints } = await visit(t, browser, server);
    await says(page, "#picture-title", /^finger$/);
    await says(page, "#state-name", /^IDLE$/);
    await server.connect("operator").emergencyStop("finger");
    await says(page, "#state-name", /^FAULT$/);
    await page.selectOption("#chooser", "rail");
    await says(page, "#picture-title", /^rail$/);
    await says(page, "#state-name", /^IDLE$/);
    await page.click("#stop");
    await says(page, "#stop-said", /^Stopped (finger, rail|rail, finger) in/);
    await says(page, "#state-name", /^FAULT$/);
    assert.deepEqual(complaints, []);
  });

  await t.test("a hand is drawn with its joints", async (t) => {
    const server = await startHapticd(t, "observe", { scene: "hand_five_fingers" });
    const { page, complaints } = await visit(t, browser, server, { colorScheme: "dark" });
    await says(page, "#grid-size", /mm$/);
    assert.equal(await page.locator("#joints tr").count(), 10);
    assert.ok(await page.locator("#chooser").isHidden());
    await page.waitForTimeout(1500);
    assert.ok(await coloursOf(page, "#picture") > 100, "the picture is blank");
    assert.deepEqual(complaints, []);
  });
});
