// A picture of hapticd's page: after SECONDS, once it is live and has nothing to complain of. If
// that is not so within another minute, there is no picture, and the last line that this prints
// says why.
//
//   node page_picture.mjs BROWSER PROFILE ADDRESS SECONDS FILE
//
// Speaks Chromium's debugging protocol over a pipe: JSON texts that end with a zero byte.
import { spawn } from "node:child_process";
import { writeFileSync } from "node:fs";
import { setTimeout as sleep } from "node:timers/promises";

const WAIT_MS = 60000;
const [browser, profile, address, seconds, file] = process.argv.slice(2);
const chromium = spawn(browser, ["--headless=new", "--no-sandbox", "--remote-debugging-pipe",
  "--enable-unsafe-swiftshader", "--hide-scrollbars", "--window-size=1280,1000",
  `--user-data-dir=${profile}`, "about:blank"],
  { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
const [, , , commands, answers] = chromium.stdio;
const waiting = new Map();
let rest = "";
answers.on("data", (bytes) => {
  const texts = (rest + bytes).split("\0");
  rest = texts.pop();
  for (const { id, result } of texts.map((text) => JSON.parse(text))) waiting.get(id)?.(result);
});
let last = 0;
function ask(method, params = {}, sessionId = undefined) {
  commands.write(`${JSON.stringify({ id: ++last, method, params, sessionId })}\0`);
  return new Promise((resolve) => waiting.set(last, resolve));
}
process.on("SIGTERM", () => chromium.kill());
const giveUp = (why) => {
  console.log(why);
  process.exit(1);
};
chromium.on("error", ({ message }) => giveUp(message));
let over = false;
chromium.on("exit", () => over || giveUp("the browser ended before it was taken"));

const { targetId } = await ask("Target.createTarget", { url: address });
const { sessionId } = await ask("Target.attachToTarget", { targetId, flatten: true });
/** The reason why it is no good picture yet; empty: none. */
async function trouble() {
  const expression = `(() => {
    const [live, bad] = ["connection", "trouble"].map((id) => document.getElementById(id));
    if (!live) return document.body?.innerText || "nothing yet";
    if (!bad.hidden) return bad.textContent;
    return live.textContent.startsWith("Live") ? "" : live.textContent;
  })()`;
  const told = await ask("Runtime.evaluate", { expression, returnByValue: true }, sessionId);
  return told?.result?.value ?? "nothing yet";
}

await sleep(1000 * Number(seconds));
let why = "";
for (const latest = Date.now() + WAIT_MS; Date.now() < latest; await sleep(200)) {
  why = await trouble();
  if (why !== "") continue;
  const { data } = await ask("Page.captureScreenshot", { format: "png" }, sessionId);
  why = await trouble();  // it may have changed meanwhile
  if (why !== "") continue;
  writeFileSync(file, Buffer.from(data, "base64"));
  break;
}
if (why !== "") console.log(`the page said: ${why.replaceAll("\n", " ").trim()}`);
over = true;
await ask("Browser.close");
