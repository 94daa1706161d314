// hapticd/mujoco against haptic::mujoco: the same models, moved by the same probe, from the same
// state at each step that is compared. MuJoCo itself is of two releases.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import * as fs from "node:fs";
import { createRequire } from "node:module";
import * as path from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";
import { part } from "./package_under_test.mjs";

const require = createRequire(path.join(process.env.HAPTICD_JS, "package.json"));
const haptic = await part("mujoco/index.js");
const load = async (file) => (await import(pathToFileURL(file).href)).default();
/** MuJoCo as npm has it, and as the page does, which may not make code of text. */
const engines = { npm: await load(require.resolve("@mujoco/mujoco")),
                  page: await load(process.env.HAPTIC_PAGE_MUJOCO) };
const vectors = process.env.HAPTIC_MUJOCO_VECTORS, models = process.env.HAPTIC_MUJOCO_MODELS;

/** Largest difference of numbers and lists of them, against the largest of its kind. */
class Differences {
  #of = {};

  add(kind, actual, expected) {
    const [a, b] = [actual, expected].map((value) => [value ?? []].flat());
    assert.equal(a.length, b.length, `${kind}: ${a} against ${b}`);
    const one = this.#of[kind] ??= { most: 0, scale: 1e-12 };
    a.forEach((value, i) => {
      one.most = Math.max(one.most, Math.abs(value - b[i]));
      one.scale = Math.max(one.scale, Math.abs(b[i]));
    });
  }
  get relative() {
    return Object.entries(this.#of).map(([kind, { most, scale }]) => [kind, most / scale]);
  }
}

const FIELDS = ["normal", "offset", "compliance", "velocity", "curvature", "firstCoordinate", "id",
  "mass", "damping", "groundStiffness", "load", "object", "objectDirection"];

function compare(name, mujoco) {
  const file = path.join(models, `${name}.xml`);
  const [head, ...lines] = execFileSync(vectors, [file], { maxBuffer: 1 << 26 }).toString().trim()
    .split("\n").map((line) => JSON.parse(line));
  const model = mujoco.MjModel.from_xml_string(fs.readFileSync(file, "utf8"));
  const data = new mujoco.MjData(model);
  model.opt.tolerance = 0;
  model.opt.iterations = 50;
  const make = [haptic.joint, haptic.point, haptic.pose];
  const bindings = head.bindings.map(([binding, kind, first]) => make[kind](binding, first));
  const tool = new haptic.Tool(mujoco, model, data, bindings, { coupling: head.coupling });
  const differences = new Differences();
  let planes = 0;
  for (const line of lines) {
    if (line.told) {
      data.qpos.set(line.qpos);
      data.qvel.set(line.qvel);
      data.qacc_warmstart.set(line.warm);
    }
    tool.aim(line.probe, 1, 20);
    tool.pull();
    if (line.told) differences.add("applied", [...data.qfrc_applied], line.applied);
    mujoco.mj_step(model, data);
    const proxy = tool.proxy();
    if (!line.told) continue;
    const order = (a, b) => a.id - b.id;
    const [told, expected] = [proxy.planes ?? [], line.told.planes].map((all) => all.sort(order));
    assert.equal(told.length, expected.length, "as many contacts");
    planes += told.length;
    differences.add("position", proxy.position, line.told.position);
    told.forEach((plane, i) => FIELDS.forEach(
      (field) => differences.add(field, plane[field], expected[i][field])));
  }
  console.log(name, planes, "planes", Object.fromEntries(
    differences.relative.map(([kind, most]) => [kind, Number(most.toPrecision(2))])));
  return { planes, differences: differences.relative };
}

const skip = !vectors && "MuJoCo's C library is not here (docker/install-deps.sh test)";
// Friction's cone is a pyramid for the finger, an ellipse for the hand.
for (const [name, engine] of [["finger", "npm"], ["hand", "page"]]) {
  test(`${name} as the C++ client, MuJoCo of ${engine}`, { skip }, () => {
    const { planes, differences } = compare(name, engines[engine]);
    assert.ok(planes > 30, `${planes} planes`);
    for (const [kind, most] of differences) assert.ok(most < 1e-9, `${kind}: ${most}`);
  });
}

/** Goes to each probe, and holds until it rests. Largest difference of what is told to what the
 * coupling's spring holds, as tests/mujoco/held_back_test.cpp has it. */
function press(mujoco, { mjcf, bindings, probes, ...options }) {
  const model = mujoco.MjModel.from_xml_string(mjcf), data = new mujoco.MjData(model);
  const said = [], kinds = ["joint", "point", "pose"];
  const bound = bindings.map(({ kind, ...binding }) => ({ kind: kinds[kind], ...binding }));
  const tool = new haptic.Tool(mujoco, model, data, bound,
                               { ...options, warn: (text) => said.push(text) });
  const off = said.splice(0), engine = new haptic.Engine(mujoco, model, data);
  let before = probes[0].map(() => 0), worst = 0, touched = 0;
  for (const probe of probes) {
    let proxy;
    for (let i = 1; i <= 45; ++i) {
      const part = Math.min(1, i / 10);
      proxy = tool.step(probe.map((x, c) => before[c] + part * (x - before[c])), 1000 / 60);
    }
    before = probe;
    const held = probe.map(() => 0), told = probe.map(
      (x, c) => proxy.position.length ? options.coupling * (x - proxy.position[c]) : 0);
    for (const { kind, name, firstCoordinate: c, scale, offset } of bound.toReversed()) {
      if (kind === "joint") {
        const at = data.qpos[engine.fixed.jointPos[engine.idOf("JOINT", name)]];
        held[c] = options.coupling * (probe[c] - (at - offset) / scale);
        continue;
      }
      const body = engine.idOf("BODY", name);
      for (let k = 0; k < 3; ++k) {
        held[c + k] = options.coupling * (probe[c + k] - data.xpos[3 * body + k]);
      }
      told.fill(0, c + 3);
    }
    const most = Math.max(...held.map(Math.abs));
    touched += told.some((force) => force !== 0);
    held.forEach((force, c) => {
      const least = Math.max(Math.abs(force), 0.05 * most, 1e-3 * options.coupling);
      worst = Math.max(worst, Math.abs(told[c] - force) / least);
    });
  }
  return { worst, touched, said, off };
}

test("what is told is what holds the tool back, or it says so", { skip, timeout: 600000 }, () => {
  const count = process.env.HAPTIC_PRESSES ?? "4";
  const models = execFileSync(vectors, ["--pressed", count], { maxBuffer: 1 << 26 }).toString()
    .trim().split("\n").map((line) => JSON.parse(line));
  let quiet = 0;
  for (const model of models) {
    const { worst, touched, said, off } = press(engines.npm, model);
    const percent = (100 * worst).toFixed(3);
    console.log(model.name, touched, "press, off by", percent, "%", ...off, ...said);
    assert.equal(said.length > 0, model.warned ?? said.length > 0, model.name);
    assert.ok(said.length > 0 || (worst <= 0.02 && touched >= count / 2), model.name);
    quiet += said.length === 0;
  }
  assert.ok(models.length >= 30 && quiet >= 24, `${quiet} of ${models.length}`);
});
