// The page without a server: what it shows of states that are made by hand, on every screen.
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  PHONE, coloursOf, eventually, fitsAcross, newPage, says, startBrowser, violations,
} from "./browser.mjs";
import { serve } from "./static_server.mjs";

const DARK = { colorScheme: "dark" };

test("the page alone", async (t) => {
  const browser = await startBrowser(t);
  const address = await serve(t, process.env.HAPTIC_PAGE_MADE);
  const open = async (t, options) => {
    const opened = await newPage(t, browser, options);
    await opened.page.goto(address);
    return opened;
  };

  for (const [name, options] of [["desk", {}], ["dark", DARK], ["phone", PHONE],
                                 ["dark phone", { ...DARK, ...PHONE }]]) {
    await t.test(`${name}: fits and is accessible`, async (t) => {
      const { page, complaints } = await open(t, options);
      await says(page, "#state-title", /^Force is on$/);
      await says(page, "#connection", /^Live/);
      await fitsAcross(page);
      assert.deepEqual(await violations(page), []);
      await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
      assert.ok(await page.locator("#stop").isVisible());
      const stop = await page.locator("#stop").boundingBox();
      const { height } = page.viewportSize();
      assert.ok(stop.y >= 0 && stop.y + stop.height <= height, "the stop is out of sight");
      assert.ok(stop.height >= 44);
      assert.deepEqual(complaints, []);
    });
  }

  await t.test("the picture shows the device", async (t) => {
    const { page } = await open(t);
    await says(page, "#grid-size", /mm$/);
    await page.waitForTimeout(1500);
    assert.ok(await coloursOf(page, "#picture") > 100);
  });

  await t.test("the address remembers the device", async (t) => {
    const { page } = await open(t);
    await says(page, "#picture-title", /^finger$/);
    await page.selectOption("#chooser", "hand");
    await says(page, "#picture-title", /^hand$/);
    assert.equal(new URL(page.url()).hash, "#device=hand");
    await page.reload();
    await says(page, "#picture-title", /^hand$/);
    assert.equal(await page.locator("#joints tr").count(), 10);
  });

  await t.test("keys stop, also while typing", async (t) => {
    const { page } = await open(t);
    await says(page, "#state-title", /^Force is on$/);
    const stops = () => page.evaluate(() => globalThis.made.stops);
    await page.keyboard.press("s");
    assert.equal(await stops(), 0);
    await page.keyboard.press("Shift+S");
    await says(page, "#stop-said", /^Stopped finger, hand in \d+ ms\.$/);
    await says(page, "#state-title", /^Stopped by a fault$/);
    await says(page, "#faults", /Emergency stop/);
    await page.keyboard.press("Escape");
    await eventually(page, () => globalThis.made.stops === 2);
    await page.focus("#stop");
    await page.keyboard.press("Enter");
    await eventually(page, () => globalThis.made.stops === 3);
  });

  await t.test("a stop is sent until answered", async (t) => {
    const { page } = await open(t);
    await says(page, "#state-title", /^Force is on$/);
    await page.evaluate(() => (globalThis.made.refuseStops = 3));
    await page.click("#stop");
    await says(page, "#stop-said", /^Not stopped yet/);
    await says(page, "#stop-said", /^Stopped /);
    assert.equal(await page.evaluate(() => globalThis.made.stops), 4);
  });

  await t.test("a fault is cleared by button", async (t) => {
    const { page } = await open(t);
    await page.evaluate(() => (globalThis.made.faults = 1 << 5));
    await says(page, "#faults", /The control loop was late LOOP_LATE/);
    await page.click("#clear");
    await says(page, "#state-title", /^Force is on$/);
    assert.deepEqual(await page.evaluate(() => globalThis.made.clears), ["finger"]);
    await page.click("#release");
    await says(page, "#action-said", /^Refused: the program .* same rank/);
  });

  await t.test("an observer is told why not", async (t) => {
    const { page } = await newPage(t, browser);
    await page.addInitScript(() => (globalThis.observe = true));
    await page.goto(address);
    await page.evaluate(() => (globalThis.made.faults = 1 << 5));
    await says(page, "#clear-why", /looking and stopping only/);
    assert.ok(await page.locator("#clear").isDisabled());
    await page.click("#other-key");
    await says(page, "#access-title", /A key that allows more/);
    assert.deepEqual(await violations(page), []);
    await page.fill("#token", "0123456789abcdef");
    await page.keyboard.press("Enter");
    await page.click("#clear");
    await says(page, "#state-title", /^Force is on$/);
  });

  await t.test("without a key it explains itself", async (t) => {
    const { page } = await newPage(t, browser, PHONE);
    await page.addInitScript(() => (globalThis.noKey = true));
    await page.goto(address);
    await says(page, "#access", /one-time token/);
    await fitsAcross(page);
    assert.deepEqual(await violations(page), []);
    await page.fill("#token", "fedcba9876543210");
    await page.keyboard.press("Enter");
    await says(page, "#token-said", /does not serve/);
    await page.fill("#token", "0123456789abcdef");
    await page.keyboard.press("Enter");
    await says(page, "#state-title", /^Force is on$/);
  });

  await t.test("a lost stream is said, and comes back", async (t) => {
    const { page } = await open(t);
    await says(page, "#connection", /^Live/);
    await page.evaluate(() => (globalThis.made.gone = true));
    await says(page, "#trouble", /^The server answers slowly: gone\. The picture is live/);
    assert.match(await page.locator("#connection").textContent(), /^Live/);
    await page.evaluate(() => globalThis.made.lose());
    await says(page, "#trouble", /^No connection to the server: gone\. What you see is old/);
    await says(page, "#connection", /^Not connected/);
    await page.evaluate(() => (globalThis.made.gone = false));
    await says(page, "#connection", /^Live/);
    await eventually(page, () => document.querySelector("#trouble").hidden);
  });

  await t.test("traces stand still when paused", async (t) => {
    const { page } = await open(t);
    await says(page, "#trace-force .value", /N$/);
    const values = () => page.locator("#traces .value").allTextContents();
    await page.click("#pause");
    await page.waitForTimeout(1500);
    const before = await values();
    await page.waitForTimeout(2500);
    assert.deepEqual(await values(), before);
    await page.click("#pause");
    await eventually(
      page, (old) => document.querySelector("#trace-position .value").textContent !== old,
      (await page.locator("#trace-position .value").allTextContents())[0]);
  });
});
