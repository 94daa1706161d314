// The page mujoco.html: a scene of MuJoCo's, felt with the device of this hapticd.

import { at, say } from "../dom";
import type { Motor, Order, Report } from "./messages";
import { Stage } from "./stage";

const EXPLAINED: Record<string, string> = {
  NO_KEY: "This page needs a key. Open the address that hapticd printed " +
    "(page: http://…?token=…), then come back here.",
  RIGHTS: "Your key may only look. To feel a scene it must allow control: start hapticd with " +
    '--set \'server.web.printed="control"\' and open the address that it prints.',
};

let stage: Stage | undefined;
let worker: Worker | undefined;
let motors: Motor[] = [];

const order = (what: Order): void => worker?.postMessage(what);

function running(on: boolean): void {
  for (const id of ["engage", "release", "reset"]) at<HTMLButtonElement>(id).disabled = !on;
}

function frame(report: Extract<Report, { kind: "frame" }>): void {
  stage?.place(report.places, report.probe, report.points);
  say(at("state"), report.state + (report.following ? "" : ", the tool is on its way"));
  say(at("contacts"), String(report.contacts));
  say(at("forces"), report.forces
    .map((force, i) => `${motors[i]?.name ?? i} ${force.toFixed(2)} ${motors[i]?.unit ?? ""}`)
    .join(", "));
  const { median, p99, frames } = report.timing;
  say(at("timing"), `${median.toFixed(1)} ms, 99 % within ${p99.toFixed(1)} ms, ${frames} frames`);
}

function hear(report: Report): void {
  if (report.kind === "frame") return frame(report);
  if (report.kind === "said") {
    if (report.reason !== "") running(false);
    return say(at("said"), EXPLAINED[report.reason] ?? report.text);
  }
  motors = report.motors;
  stage?.show(report.geoms, report.up);
  say(at("device"), report.device);
  running(true);
}

at("start").addEventListener("click", () => {
  worker?.terminate();
  running(false);
  try {
    stage ??= new Stage(at<HTMLCanvasElement>("picture"));
  } catch (error) {
    say(at("said"), `This browser draws no 3D picture: ${String(error)}`);
  }
  worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
  worker.onmessage = ({ data }: MessageEvent<Report>) => hear(data);
  worker.onerror = ({ message }) => say(at("said"), message);
  order({ kind: "start", scene: at<HTMLSelectElement>("model").value });
});
for (const kind of ["engage", "release", "reset"] as const) {
  at(kind).addEventListener("click", () => order({ kind }));
}
let before = 0;
setInterval(() => {
  const painted = stage?.painted ?? 0;
  say(at("painted"), `${painted - before} pictures/s`);
  before = painted;
}, 1000);
