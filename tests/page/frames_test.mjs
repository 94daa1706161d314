// Where the bodies of a drawing stand: against geometry worked out by hand.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { frames } from "../../server/front/page/src/picture/frames.ts";
import { gridStep } from "../../server/front/page/src/picture/view.ts";

const [ROTATION, TRANSLATION, ORIENTATION, ROTATION_VECTOR, AIM] = [1, 2, 3, 4, 5];
const [Q, X] = [1, 2];

const motion = (kind, value, index, more = {}) => ({
  kind, value, index, axis: [0, 0, 1], factor: 1, offset: 0, target: 0, targetPoint: [], ...more,
});
const body = (parent, position, ...motions) => ({
  name: "", part: 1, parent, position, orientation: [], motions, capsules: [],
});
const drawing = (...bodies) => ({ bodies, forces: [] });

/** Where a point of a body's frame is in the world. */
function at(frame, point = [0, 0, 0]) {
  return new Vector3(...point).applyMatrix4(frame).toArray();
}
function near(actual, expected) {
  actual.forEach((value, i) => assert.ok(Math.abs(value - expected[i]) < 1e-12,
                                         `${actual} is not ${expected}`));
}

test("a link turns and its slide follows", () => {
  const all = frames(
    drawing(body(-1, [1, 0, 0], motion(ROTATION, Q, 0, { factor: -2, offset: 0.1 })),
            body(0, [2, 0, 0], motion(TRANSLATION, Q, 1, { axis: [0, 1, 0] }))),
    [0.3, 0.5], []);
  const angle = -2 * 0.3 + 0.1, [c, s] = [Math.cos(angle), Math.sin(angle)];
  near(at(all[1]), [1 + 2 * c - 0.5 * s, 2 * s + 0.5 * c, 0]);
});

test("the tool moves with x alone", () => {
  const tool = drawing(body(-1, [], motion(TRANSLATION, X, 1, { axis: [1, 0, 0] })));
  near(at(frames(tool, [9, 9], [7, 0.25])[0]), [0.25, 0, 0]);
});

test("four values turn it", () => {
  const half = Math.SQRT1_2;
  const turned = drawing(body(-1, [], motion(ORIENTATION, Q, 1)));
  near(at(frames(turned, [9, 0, 0, 2 * half, 2 * half], [])[0], [1, 0, 0]), [0, 1, 0]);
  near(at(frames(turned, [9, 0, 0, 0, 0], [])[0], [1, 0, 0]), [1, 0, 0]);
});

test("three values are axis times angle", () => {
  const turned = drawing(body(-1, [], motion(ROTATION_VECTOR, Q, 0)));
  near(at(frames(turned, [0, Math.PI / 2, 0], [])[0], [1, 0, 0]), [0, 0, -1]);
  near(at(frames(turned, [0, 0, 0], [])[0], [1, 2, 3]), [1, 2, 3]);
});

test("a link aims at its target", () => {
  const point = [0.3, 0.4, 0], offset = 0.12;
  const [, aiming] = frames(
    drawing(body(-1, [1, 2, 0], motion(ROTATION, Q, 0)),
            body(-1, [-0.2, 0.1, 0],
                 motion(AIM, 0, 0, { target: 0, targetPoint: point, offset }))),
    [0.7], []);
  const [c, s] = [Math.cos(0.7), Math.sin(0.7)];
  const target = new Vector3(1 + c * 0.3 - s * 0.4, 2 + s * 0.3 + c * 0.4, 0);
  const seen = target.clone().applyMatrix4(aiming.clone().invert());
  assert.ok(Math.abs(seen.y - offset) < 1e-12);
  assert.ok(seen.x > 0);
  assert.ok(Math.abs(seen.length() - target.distanceTo(new Vector3(-0.2, 0.1, 0))) < 1e-12);
});

test("unknown motions leave body and children out", () => {
  const all = frames(
    drawing(body(-1, [], motion(99, Q, 0)), body(0, [1, 0, 0]), body(-1, [])), [1], []);
  assert.deepEqual(all.map((frame) => frame !== null), [false, false, true]);
});

test("a missing value counts as zero", () => {
  const slides = drawing(body(-1, [1, 0, 0], motion(TRANSLATION, Q, 5, { axis: [1, 0, 0] })));
  near(at(frames(slides, [NaN], [])[0]), [1, 0, 0]);
});

test("the grid has round steps", () => {
  near([0.13, 0.08, 1, 0.4].map(gridStep), [0.02, 0.01, 0.2, 0.05]);
});
