// From the press of the button to the latched fault: 50 ms (p99) on a machine that does nothing
// else. One program presses the button through the browser's debugger and hears the server's event
// of the fault, by one clock: the time includes both of those ways.
import assert from "node:assert/strict";
import { test } from "node:test";
import { eventually, open } from "../client/js/hapticd_process.mjs";
import { eventually as onPage, newPage, says, startBrowser } from "./browser.mjs";
import { printedAddress, startHapticd } from "./live_server.mjs";

const STOPS = 200;
const LONGEST_MS = 50;
const FAULT = 3; // Event.kind

/** Notes in `pressed` and `shown` when the button goes down, and when the page says the fault: both
 * by the page's clock. */
function watchStops() {
  const name = document.querySelector("#state-name");
  document.querySelector("#stop").addEventListener("pointerdown", (event) => {
    globalThis.pressed = event.timeStamp;
  }, true);
  new MutationObserver(() => {
    if (name.textContent === "FAULT") globalThis.shown = performance.now();
  }).observe(name, { childList: true, characterData: true, subtree: true });
}

/** Says the figures; returns p99. */
function p99(what, times) {
  times.sort((a, b) => a - b);
  const at = (share) => times[Math.ceil(share * times.length) - 1];
  const [median, high, worst] = [at(0.5), at(0.99), at(1)].map((ms) => ms.toFixed(1));
  console.log(`${times.length} stops ${what}: median ${median}, p99 ${high}, worst ${worst} ms`);
  return at(0.99);
}

test("a stop takes 50 ms at most", async (t) => {
  const server = await startHapticd(t, "control");
  let heard;
  await open(t, server.connect("observe"), {
    role: "observer",
    onEvent: ({ kind }) => {
      if (kind === FAULT) heard ??= performance.now();
    },
  });
  const operator = server.connect("operator");
  const browser = await startBrowser(t);
  const { page } = await newPage(t, browser);
  await page.goto(await printedAddress(server));
  await says(page, "#state-name", /^IDLE$/);
  await page.evaluate(watchStops);
  const stop = await page.locator("#stop").boundingBox();
  const latched = [], shown = [];
  for (let i = 0; i < STOPS; i++) {
    await page.mouse.move(stop.x + stop.width / 2, stop.y + stop.height / 2);
    await page.evaluate(() => {
      globalThis.shown = undefined;
      document.querySelector("#stop-said").textContent = "";
    });
    heard = undefined;
    const pressed = performance.now();
    await page.mouse.down();
    await page.mouse.up();
    await onPage(page, () => globalThis.shown);
    latched.push(await eventually(() => heard, "the fault's event") - pressed);
    // Else it might send the stop again, after the fault was cleared.
    await says(page, "#stop-said", /^Stopped/);
    shown.push(await page.evaluate(() => globalThis.shown - globalThis.pressed));
    await eventually(() => operator.clearFault().then(() => true, () => false));
    await says(page, "#state-name", /^IDLE$/);
  }
  p99("until the page shows it", shown);
  const longest = p99("until the fault is latched", latched);
  assert.ok(longest <= LONGEST_MS, `${longest} ms`);
});
