// The page mujoco.html: a scene of MuJoCo's, felt with the device of this hapticd.

import { Connection } from "hapticd";
import { at, say } from "../dom";
import { misfit } from "./fit";
import { Stop } from "../panels/stop";
import { stateWords } from "../words";
import type { Motor, Order, Report } from "./messages";
import { Stage } from "./stage";

const EXPLAINED: Record<string, string> = {
  NO_KEY: "This page needs a key. Open the address that hapticd printed " +
    "(page: http://…?token=…), then come back here.",
  RIGHTS: "Your key may only look. To feel a scene it must allow control: start hapticd with " +
    '--set \'server.web.printed="control"\' and open the address that it prints.',
  LEASE_HELD: "Another program controls the device. End it, then press Start again.",
};

let stage: Stage | undefined;
let worker: Worker | undefined;
let motors: Motor[] = [];
let asked = false; // for force

const order = (what: Order): void => worker?.postMessage(what);

function running(on: boolean): void {
  for (const id of ["engage", "release", "reset"]) at<HTMLButtonElement>(id).disabled = !on;
}

/** No scene runs. */
function idle(): void {
  running(false);
  asked = false;
  delete at("state").dataset.state;
  say(at("state"), "Not started.");
  for (const id of ["touch", "pushed", "forces"]) say(at(id), "");
  at("fault").hidden = true;
  stage?.press(new Float32Array());
}

/** "You touch the ball and the box." */
function touchWords(touched: string[]): string {
  const things = touched.map((name) => (name === "" ? "something" : `the ${name}`)).sort();
  return `You touch ${things.length > 0 ? things.join(" and ") : "nothing"}.`;
}

function frame(report: Extract<Report, { kind: "frame" }>): void {
  running(true);
  const { name, title, tone } = stateWords(report.state);
  stage?.place(report);
  stage?.press(tone === "force" ? report.presses : new Float32Array());
  at("state").dataset.state = name;
  if (tone === "fault") asked = false;
  at("fault").hidden = tone !== "fault";
  const hint = name === "ARMED" && !asked ? " Press Force on." : "";
  say(at("state"), `${title}.${report.refusal ? ` No force yet: ${report.refusal}.` : hint}`);
  say(at("touch"), report.following ? touchWords(report.touched)
    : "The finger or hand is on its way to the device.");
  say(at("pushed"), (stage?.pushed() ?? [])
    .map(({ name, mm }) => `The ${name} has moved by ${mm} mm.`).join(" "));
  say(at("forces"), report.forces
    .map((force, i) => `${motors[i]?.name ?? i} ${force.toFixed(2)} ${motors[i]?.unit ?? ""}`)
    .join(", "));
  const { median, p99, frames } = report.timing;
  order({ kind: "shown" });
  say(at("timing"), `${median.toFixed(1)} ms, 99 % within ${p99.toFixed(1)} ms, ${frames} frames`);
}

function hear(report: Report): void {
  if (report.kind === "frame") return frame(report);
  if (report.kind === "said") {
    if (report.reason !== "") idle();
    return say(at("said"), EXPLAINED[report.reason] ?? report.text);
  }
  motors = report.motors;
  stage?.show(report.geoms, report.up);
  say(at("device"), report.device);
}

const stopper = new Connection(undefined, { timeoutMs: 1000 });
new Stop(() => ({ stop: () => stopper.emergencyStop("", "stop on the MuJoCo page") }));

/** The part of the device that the scene lacks, that that a session gets; empty: nothing. */
async function lacks(scene: string): Promise<string> {
  const [[device], answer] = await Promise.all(
    [stopper.listDevices(), fetch(new URL(`${scene}.xml`, import.meta.url))]);
  return misfit(await answer.text(), device?.coordinates ?? []);
}
const model = at<HTMLSelectElement>("model");
const first = model.value;
async function choose(): Promise<void> {
  for (const { value } of model.options) {
    if (model.value !== first) return; // a person was faster
    if (await lacks(value) !== "") continue;
    model.value = value;
    return;
  }
}
choose().catch(() => undefined); // Start says what is wrong

async function start(): Promise<void> {
  // Before the scene that runs ends. What else is wrong, the worker explains.
  const missing = await lacks(model.value).catch(() => "");
  if (missing !== "") {
    return say(at("said"), `This scene is not for this device: it has no '${missing}'. ` +
      "Choose another.");
  }
  worker?.terminate();
  idle();
  try {
    stage ??= new Stage(at<HTMLCanvasElement>("picture"));
  } catch (error) {
    say(at("said"), `This browser draws no 3D picture: ${String(error)}`);
  }
  worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
  worker.onmessage = ({ data }: MessageEvent<Report>) => hear(data);
  worker.onerror = ({ message }) => hear({ kind: "said", text: message, reason: "UNKNOWN" });
  order({ kind: "start", scene: model.value });
}
let starting = false;
at("start").addEventListener("click", () => {
  if (starting) return;
  starting = true;
  void start().finally(() => (starting = false));
});
for (const kind of ["engage", "release", "reset"] as const) {
  at(kind).addEventListener("click", () => {
    if (kind !== "reset") asked = kind === "engage";
    order({ kind });
  });
}
let before = 0;
setInterval(() => {
  const painted = stage?.painted ?? 0;
  say(at("painted"), `${painted - before} pictures/s`);
  before = painted;
}, 1000);
