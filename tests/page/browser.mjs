// A browser of a test's own: Debian's chromium without a screen, driven by playwright-core.
// $HAPTIC_PAGE_MODULES is the node_modules that has it; $CHROMIUM names the program.
import assert from "node:assert/strict";
import * as fs from "node:fs";
import { createRequire } from "node:module";
import * as path from "node:path";
import { setTimeout as sleep } from "node:timers/promises";

const require = createRequire(path.join(process.env.HAPTIC_PAGE_MODULES, "package.json"));
const { chromium } = require("playwright-core");
const AXE = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

const DESK = { viewport: { width: 1280, height: 800 } };
export const PHONE = { viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true };
/** A machine that builds something else at the same time is slow, and not wrong. */
const PATIENCE_MS = 60000;

/** Starts it; it ends with the test `t`. */
export async function startBrowser(t) {
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM,
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
           "--enable-unsafe-swiftshader"],
  });
  t.after(() => browser.close());
  return browser;
}

/** An empty page, which ends with the test `t`; `complaints` collects what it says on its console,
 * and what it throws. */
export async function newPage(t, browser, options = {}) {
  const context = await browser.newContext({ ...DESK, reducedMotion: "reduce", ...options });
  t.after(() => browser.isConnected() && context.close());
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  const complaints = [];
  page.on("console", (message) => {
    if (message.type() === "error") complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(error.message));
  return { page, complaints };
}

/** Waits until `condition`, a function of the page, holds. Its policy forbids playwright's own
 * waiting, which evaluates text inside the page. */
export async function eventually(page, condition, argument) {
  const latest = Date.now() + PATIENCE_MS;
  while (!(await page.evaluate(condition, argument))) {
    if (Date.now() > latest) throw new Error(`not so: ${condition} ${JSON.stringify(argument)}`);
    await sleep(50);
  }
}

/** Waits until the element's text matches. */
export async function says(page, selector, pattern) {
  const latest = Date.now() + PATIENCE_MS;
  for (;;) {
    const text = await page.evaluate(
      (where) => document.querySelector(where)?.textContent ?? "", selector);
    if (pattern.test(text)) return;
    if (Date.now() > latest) throw new Error(`${selector} says '${text}', not ${pattern}`);
    await sleep(50);
  }
}

/** Findings of axe-core, as sentences. */
export async function violations(page) {
  // Not as a <script>, which the page's policy forbids: as the debugger evaluates it.
  await page.evaluate(AXE);
  const { violations: found } = await page.evaluate(() => globalThis.axe.run());
  return found.map(({ id, nodes }) =>
    `${id}: ${nodes.map(({ html, failureSummary }) => `${html} ${failureSummary}`).join("; ")}`);
}

/** How many colours the picture has: a blank one has one. */
export async function coloursOf(page, selector) {
  const picture = await page.locator(selector).screenshot();
  return page.evaluate(async (bytes) => {
    const image = await createImageBitmap(new Blob([new Uint8Array(bytes)]));
    const canvas = new OffscreenCanvas(image.width, image.height).getContext("2d");
    canvas.drawImage(image, 0, 0);
    const data = new Uint32Array(canvas.getImageData(0, 0, image.width, image.height).data.buffer);
    return new Set(data).size;
  }, [...picture]);
}

/** Everything lies within the window from left to right. */
export async function fitsAcross(page) {
  const [needs, has] = await page.evaluate(
    () => [document.documentElement.scrollWidth, document.documentElement.clientWidth]);
  assert.ok(needs <= has, `the page needs ${needs} pixels, and has ${has}`);
}
