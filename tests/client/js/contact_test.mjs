// Contacts and proxies against the shared vectors of all languages (make_contacts.py), and what is
// refused.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { part } from "./package_under_test.mjs";

const haptic = await part("index.js");
const vectors = JSON.parse(readFileSync(new URL("../contacts.json", import.meta.url), "utf8"));

function pointOf(tool, x) {
  if (tool.kind === "itself") return haptic.pointItself(x, tool.first);
  if (tool.kind === "pose") return haptic.pointOnPose(x, tool.offset, tool.first);
  if (tool.kind === "joints") return haptic.pointOnJoints(tool.joints, tool.point, tool.first);
  const { lengths, phalanx, along, palmar, first } = tool;
  return haptic.pointOnFinger(lengths, x, phalanx, along, palmar, first);
}

function contactOf(told, x) {
  const { shape, centre, axis, radius } = told.object, point = pointOf(told.tool, x);
  let away = point.position.map((p, k) => p - centre[k]);
  const along = away.reduce((sum, a, k) => sum + a * axis[k], 0);
  if (shape === "rod") away = away.map((a, k) => a - along * axis[k]);
  const distance = radius > 0 ? Math.hypot(...away) : -Math.hypot(...away);
  const normal = shape === "wall" ? axis : away.map((a) => a / distance);
  return { point, normal, gap: shape === "wall" ? along : distance - radius,
    ...(shape === "ball" && { curvature: haptic.sphereCurvature(normal, distance) }),
    ...(shape === "rod" && { curvature: haptic.cylinderCurvature(normal, axis, distance) }),
    ...(told.stiffness !== "rigid" && { stiffness: told.stiffness }),
    ...(told.uncertainty !== null && { uncertainty: told.uncertainty }),
    ...(told.direction.length > 0 && { objectDirection: told.direction }),
    velocity: told.velocity, id: told.id, mass: told.mass, damping: told.damping,
    groundStiffness: told.ground_stiffness, load: told.load, object: told.on };
}

function near(actual, expected, within) {
  assert.equal(actual.length, expected.length);
  for (const [i, value] of actual.entries()) {
    assert.ok(Math.abs(value - expected[i]) <= within, `${i}: ${value}, not ${expected[i]}`);
  }
}

test("planes are the shared ones", () => {
  for (const { contact, x, coupling, plane: expected } of vectors.planes) {
    const plane = haptic.contactAt(x, contactOf(contact, x), coupling);
    near(plane.normal, expected.normal, 1e-15);
    near(plane.curvature, expected.curvature, 1e-13);
    near(plane.objectDirection, expected.object_direction, 1e-15);
    near([plane.offset, plane.compliance, plane.velocity, plane.mass, plane.damping,
      plane.groundStiffness, plane.load], [expected.offset, expected.compliance, expected.velocity,
      expected.mass, expected.damping, expected.ground_stiffness, expected.load], 1e-15);
    assert.deepEqual(
      [plane.uncertainty ?? null, plane.firstCoordinate, plane.id, plane.object],
      [expected.uncertainty, expected.first_coordinate, expected.id, expected.object]);
  }
});

test("proxies are the shared ones", () => {
  for (const { contacts, x_probe, start, weights, coupling, x } of vectors.solve) {
    const found = haptic.solve((y) => contacts.map((told) => contactOf(told, y)), x_probe,
      coupling, { start, weights });
    assert.ok(found.converged && found.iterations <= 12);
    near(found.x, x, 1e-10);
    assert.equal(found.proxy.planes.length, contacts.length);
  }
});

test("horizons are the shared ones", () => {
  for (const { round_trip_s: roundTrip, period_s: period, v_max: vMax, metres } of
    vectors.horizon) {
    near([haptic.contactHorizon(1e3 * roundTrip, 1e3 * period, vMax)], [metres], 1e-15);
  }
});

const wall = (gap, slope, stiffness) => ({ point: { firstCoordinate: 0, position: [0, 0, 0],
  jacobian: [[slope, 0, 0]], second: [] }, normal: [1, 0, 0], gap, stiffness });

test("contradictions do not converge", () => {
  const found = haptic.solve(([x]) => [wall(-x, -1), wall(x - 1, 1)], [5], 1);
  assert.equal(found.converged, false);
  near(found.x, [0.5], 1e-6);
});

test("solve stops after its iterations", () => {
  const ball = (x) => contactOf({ ...vectors.solve[0].contacts[0], id: 1 }, x);
  const found = haptic.solve((x) => [ball(x)], [0.003, 0.001, 0], 1,
    { start: [0, 0.03, 0], iterations: 2 });
  assert.deepEqual([found.converged, found.iterations], [false, 2]);
});

test("what is not allowed is named", () => {
  for (const [contacts, xProbe, coupling, options, words] of [
    [[], [0, NaN], 1, {}, "xProbe[1]: NaN, must be finite"],
    [[], [0], 0, {}, "coupling[0]: 0, must be finite and > 0"],
    [[], [0], 1, { start: [0, 0] }, "options.start: has 2 values, must have 1"],
    [[], [0], 1, { weights: [0] }, "options.weights[0]: 0, must be finite and > 0"],
    [[wall(NaN, 1)], [0], 1, {}, "contacts[0].gap: NaN, must be finite"],
    [[wall(0, 1, -1)], [0], 1, {}, "contacts[0].stiffness: -1, must be > 0"],
    [[wall(0, NaN)], [0], 1, {}, "contacts[0].normal . point.jacobian[0]: NaN, must be finite"],
  ]) {
    assert.throws(() => haptic.solve(() => contacts, xProbe, coupling, options),
      { name: "RangeError", message: words });
  }
});

test("coordinates beyond x are refused", () => {
  const outside = { point: haptic.pointItself([0, 0, 0, 0], 1), normal: [1, 0, 0], gap: 0 };
  assert.throws(() => haptic.contactAt([0, 0, 0], outside, 1), RangeError);
});
