// A picture of a page after some seconds.
//
//   node page_picture.mjs BROWSER PROFILE ADDRESS SECONDS FILE
//
// Speaks Chromium's debugging protocol over a pipe: JSON texts that end with a zero byte.
import { spawn } from "node:child_process";
import { writeFileSync } from "node:fs";
import { setTimeout as sleep } from "node:timers/promises";

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
chromium.on("exit", () => process.exit(0));

const { targetId } = await ask("Target.createTarget", { url: address });
const { sessionId } = await ask("Target.attachToTarget", { targetId, flatten: true });
await sleep(1000 * Number(seconds));
const { data } = await ask("Page.captureScreenshot", { format: "png" }, sessionId);
writeFileSync(file, Buffer.from(data, "base64"));
await ask("Browser.close");
