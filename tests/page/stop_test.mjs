// From the press of the button to the latched fault: 50 ms (p99) on a machine that does nothing
// else. A program on the same machine hears the server's event of the fault, and the page shows it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { eventually, open } from "../client/js/hapticd_process.mjs";
import { newPage, says, startBrowser } from "./browser.mjs";
import { printedAddress, startHapticd } from "./live_server.mjs";

const STOPS = 40;
const LONGEST_MS = 50;
const FAULT = 3; // Event.kind

/** ms since 1970, by the clock that pages have too. */
const now = () => performance.timeOrigin + performance.now();

/** Notes in `pressed` and `shown` when the button goes down, and when the page says the fault. */
function watchStops() {
  const name = document.querySelector("#state-name");
  document.querySelector("#stop").addEventListener("pointerdown", (event) => {
    globalThis.pressed = performance.timeOrigin + event.timeStamp;
  }, true);
  new MutationObserver(() => {
    if (name.textContent === "FAULT") globalThis.shown = performance.timeOrigin + performance.now();
  }).observe(name, { childList: true, characterData: true, subtree: true });
}

/** Says the figures; the worst of 40 stands for p99. */
function worst(what, times) {
  times.sort((a, b) => a - b);
  const [middle, last] = [times[times.length / 2], times.at(-1)];
  console.log(`${times.length} stops ${what}: median ${middle.toFixed(1)} ms, ` +
    `worst ${last.toFixed(1)} ms`);
  return last;
}

test("a stop takes 50 ms at most", async (t) => {
  const server = await startHapticd(t, "control");
  let heard = 0;
  await open(t, server.connect("observe"), {
    role: "observer",
    onEvent: ({ kind }) => {
      if (kind === FAULT) heard = now();
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
    await page.mouse.click(stop.x + stop.width / 2, stop.y + stop.height / 2);
    await says(page, "#state-name", /^FAULT$/);
    const [begin, end] = await page.evaluate(() => [globalThis.pressed, globalThis.shown]);
    latched.push(heard - begin);
    shown.push(end - begin);
    await eventually(() => operator.clearFault().then(() => true, () => false));
    await says(page, "#state-name", /^IDLE$/);
  }
  worst("until the page shows it", shown);
  const longest = worst("until the fault is latched", latched);
  assert.ok(Math.min(...latched) > 0, "the clocks differ");
  assert.ok(longest <= LONGEST_MS, `${longest} ms`);
});
