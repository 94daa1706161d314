// How long the worker of this test's browser computes. Linux counts it, so that other programs,
// which make it wait for a core, do not matter.
import * as fs from "node:fs";
import { setTimeout as sleep } from "node:timers/promises";

const read = (...way) => fs.readFileSync(["/proc", ...way].join("/"), "utf8");

function isOfThisTest(process_) {
  let pid = process_;
  while (Number(pid) > 1 && Number(pid) !== process.pid) {
    pid = /PPid:\s+(\d+)/.exec(read(pid, "status"))[1];
  }
  return Number(pid) === process.pid;
}

/** The schedstat of its thread. */
function findWorker() {
  for (const pid of fs.readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      if (!isOfThisTest(pid)) continue;
      for (const thread of fs.readdirSync(`/proc/${pid}/task`)) {
        const where = [pid, "task", thread];
        if (read(...where, "comm").startsWith("DedicatedWorker")) return [...where, "schedstat"];
      }
    } catch {}  // it ended meanwhile
  }
  throw new Error("the browser has no worker");
}

/** Per 16 ms in which it computed, ms, in rising order, until `over` is kept. A span for which
 * this program was late has several frames, and does not count. */
export async function workerTimes(over) {
  const worker = findWorker(), times = [];
  let ended = false;
  over.finally(() => (ended = true)).catch(() => undefined);
  for (let [last, , turns] = read(...worker).split(" "); !ended;) {
    const begin = performance.now();
    await sleep(16);
    const [now, , taken] = read(...worker).split(" ");
    if (taken !== turns && performance.now() - begin < 24) times.push((now - last) * 1e-6);
    [last, turns] = [now, taken];
  }
  return times.sort((a, b) => a - b);
}
