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
const { default: loadMujoco } =
  await import(pathToFileURL(require.resolve("@mujoco/mujoco")).href);
const haptic = await part("mujoco/index.js");
const mujoco = await loadMujoco();
const vectors = process.env.HAPTIC_MUJOCO_VECTORS, models = process.env.HAPTIC_MUJOCO_MODELS;

function load(xml) {
  const model = mujoco.MjModel.from_xml_string(xml);
  return [model, new mujoco.MjData(model)];
}

/** What differs most, of numbers and lists of them, against the largest of its kind. */
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

function compare(name) {
  const file = path.join(models, `${name}.xml`);
  const [head, ...lines] = execFileSync(vectors, [file], { maxBuffer: 1 << 26 }).toString().trim()
    .split("\n").map((line) => JSON.parse(line));
  const [model, data] = load(fs.readFileSync(file, "utf8"));
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
for (const name of ["finger", "hand"]) {
  test(`${name} as the C++ client`, { skip }, () => {
    const { planes, differences } = compare(name);
    assert.ok(planes > 30, `${planes} planes`);
    for (const [kind, most] of differences) assert.ok(most < 1e-9, `${kind}: ${most}`);
  });
}
