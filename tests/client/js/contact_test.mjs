// Contacts from a simulation's geometry, against differences of the gap itself.
import assert from "node:assert/strict";
import { test } from "node:test";
import { part } from "./package_under_test.mjs";

const haptic = await part("index.js");
const RADIUS = 0.02, CENTRE = [0.06, 0.01, 0.02], STEP = 1e-4;

/** A slide along (0.6, 0.8, 0), and a hinge about z on it. */
function slideAndHinge(x) {
  const hinge = [0.6 * x[1], 0.8 * x[1], 0];
  const point = [hinge[0] + 0.03 * Math.cos(x[2]), hinge[1] + 0.03 * Math.sin(x[2]), 0.01];
  return haptic.pointOnJoints([{ origin: [0, 0, 0], axis: [0.6, 0.8, 0], prismatic: true },
    { origin: hinge, axis: [0, 0, 1] }], point, 1);
}

function contact(point, x, rod) {
  const away = point.position.map((p, k) => (rod && k === 2 ? 0 : p - CENTRE[k]));
  const distance = Math.hypot(...away), normal = away.map((a) => a / distance);
  const curvature = rod ? haptic.cylinderCurvature(normal, [0, 0, 1], distance)
                        : haptic.sphereCurvature(normal, distance);
  const gap = distance - RADIUS;
  return { gap, plane: haptic.contactAt(x, { point, normal, gap, curvature, stiffness: 400, id: 7,
    mass: 0.2, damping: 3, groundStiffness: 50, load: -1, object: rod ? 3 : 0 }, 0.02) };
}

function moved(x, ...by) {
  const there = [...x];
  for (const [i, step] of by) there[i] += step;
  return there;
}

const near = (actual, expected, within) =>
  assert.ok(Math.abs(actual - expected) <= within, `${actual}, not ${expected}`);

for (const [name, point, x] of [
  ["joints", slideAndHinge, [9, 0.02, 0.4]],
  ["a finger", (y) => haptic.pointOnFinger([0.045, 0.03], y, 1, 0.02, 0.008, 1), [9, 0.4, 0.8]],
  ["a point", (y) => haptic.pointItself(y, 1), [9, 0.01, 0.02, 0.03]],
  ["a pose", (y) => haptic.pointOnPose(y, [0.03, -0.02, 0.05], 1),
   [9, 0.01, 0.02, 0.03, 0.1, -0.2, 0.3, Math.sqrt(0.86)]],
]) {
  for (const rod of [false, true]) {
    test(`the gap of ${name} at a ${rod ? "rod" : "ball"}`, () => {
      const gap = (y) => contact(point(y), y, rod).gap;
      const { plane } = contact(point(x), x, rod);
      near(plane.normal.reduce((sum, a, i) => sum - a * x[i], plane.offset), gap(x), 1e-15);
      assert.deepEqual([plane.compliance, plane.mass, plane.damping, plane.groundStiffness,
        plane.load], [5e-5, 10, 150, 2500, -50]);
      assert.deepEqual([plane.firstCoordinate, plane.id, plane.object,
        plane.objectDirection.length], [1, 7, rod ? 3 : 0, rod ? 3 : 0]);
      near(plane.normal[0], 0, 0);
      for (let i = 1, k = 0; i < x.length; ++i) {
        const slope = (gap(moved(x, [i, STEP])) - gap(moved(x, [i, -STEP]))) / (2 * STEP);
        near(-plane.normal[i], slope, 1e-6);
        for (let j = 1; j <= i; ++j, ++k) {
          let second = 0;
          for (const [a, b] of [[1, 1], [1, -1], [-1, 1], [-1, -1]]) {
            second += a * b * gap(moved(x, [i, a * STEP], [j, b * STEP]));
          }
          near(plane.curvature[k], second / (4 * STEP * STEP), 1e-3);
        }
      }
    });
  }
}

test("coordinates beyond x are refused", () => {
  const outside = { point: haptic.pointItself([0, 0, 0, 0], 1), normal: [1, 0, 0], gap: 0 };
  assert.throws(() => haptic.contactAt([0, 0, 0], outside, 1), RangeError);
});

test("the horizon is how far points get", () => {
  near(haptic.contactHorizon(100, 20), 0.06, 1e-15);
  near(haptic.contactHorizon(0, 0), 0.1, 1e-15);
});
