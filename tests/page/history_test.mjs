// The rows behind a trace.
import assert from "node:assert/strict";
import { test } from "node:test";
import { History } from "../../server/front/page/src/traces/history.ts";

test("a window has its rows alone", () => {
  const history = new History(1, 100);
  for (let i = 0; i < 50; i++) history.push(i, [10 * i]);
  const [times, values] = history.window(49, 2.5);
  assert.deepEqual(times, [-3, -2, -1, 0]); // one more, from where the line comes
  assert.deepEqual(values, [460, 470, 480, 490]);
});

test("old rows make room", () => {
  const history = new History(2, 10);
  for (let i = 0; i < 1000; i++) history.push(i, [i, -i]);
  const [times, up, down] = history.window(999, 1000);
  assert.deepEqual(times, [-9, -8, -7, -6, -5, -4, -3, -2, -1, 0]);
  assert.equal(up[0], 990);
  assert.equal(down[9], -999);
});

test("a cut leaves a gap", () => {
  const history = new History(1, 10);
  history.push(1, [5]);
  history.cut();
  history.push(2, [6]);
  assert.deepEqual(history.window(2, 9)[1], [5, null, 6]);
});

test("time does not run backwards", () => {
  const history = new History(1, 10);
  history.push(2, [1]);
  history.push(2, [2]);
  history.push(1, [3]);
  assert.deepEqual(history.window(2, 9)[1], [1]);
});

test("a pause does not see later rows", () => {
  const history = new History(1, 10);
  for (let i = 0; i < 5; i++) history.push(i, [i]);
  assert.deepEqual(history.window(2, 1)[1], [0, 1, 2]);
});

test("what is no number is a gap", () => {
  const history = new History(2, 10);
  history.push(1, [NaN]);
  assert.deepEqual(history.window(1, 1), [[0], [null], [null]]);
});
