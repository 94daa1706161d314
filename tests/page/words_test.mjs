// Words and numbers of the page.
import assert from "node:assert/strict";
import { test } from "node:test";
import { bitWords } from "hapticd";
import { misfit } from "../../server/front/page/src/mujoco/fit.ts";
import { howLong, number, quantity } from "../../server/front/page/src/units.ts";
import { changeWords, contactWords, deratingWords, proxyWords }
  from "../../server/front/page/src/words.ts";

test("every bit of the protocol has words", () => {
  for (const field of ["faults", "limiters"]) {
    const named = bitWords(field, -1).filter(({ name }) => !/^\d+$/.test(name));
    assert.ok(named.length > 12);
    assert.deepEqual(named.filter(({ help }) => /does not know/.test(help)), []);
  }
});

test("bits become words", () => {
  assert.deepEqual(bitWords("faults", 1 << 7).map(({ title }) => title), ["Emergency stop"]);
  assert.deepEqual(bitWords("limiters", 0b11).map(({ name }) => name), ["SATURATION", "SLEW"]);
  assert.deepEqual(bitWords("faults", 1 << 31).map(({ title }) => title), ["Bit 31"]);
  assert.deepEqual(bitWords("faults", 0), []);
});

test("touch is said in words", () => {
  const state = { proxySeqUsed: 1n, mode: 3, activePlanes: 0 };
  assert.match(contactWords(state), /^Not touching/);
  assert.match(contactWords({ ...state, activePlanes: 1 << 4 }), /surface 4 of the/);
  assert.match(contactWords({ ...state, activePlanes: 0b1101 }), /3 surfaces of .*: 0, 2 and 3\./);
  assert.match(contactWords({ ...state, activePlanes: -1 }), /32 surfaces/);
  assert.match(contactWords({ ...state, mode: 2 }), /Nothing is in the way/);
  assert.match(contactWords({ ...state, proxySeqUsed: 0n }), /no simulation/);
  assert.match(proxyWords({ proxySeqUsed: 1n, proxyAgeUs: 12345n, staleness: 1 }), /12\.3 ms/);
});

test("a change of state is a sentence", () => {
  assert.equal(changeWords("ENGAGING -> ENGAGED"), "Force is on");
  assert.equal(changeWords("LEASE_GRANTED"), "");
});

test("the softest actuator is named", () => {
  const dof = (name) => ({ name, unit: "m", actuated: true });
  const device = { dofs: [dof("a"), dof("b")], stiffnessLimit: [1000, 1500] };
  const state = { derating: 2, gain: 0.5, stiffnessInEffect: [450, 300], deratingDelayUs: 50000n };
  assert.equal(deratingWords(device, state), "b 1500 → 600.0 N/m: the held proxy is 50 ms old");
  assert.equal(deratingWords(device, { ...state, gain: 0 }), "");
  assert.equal(deratingWords(device, { ...state, derating: 0 }), "");
});

test("a scene fits by its names", () => {
  const names = (...all) => all.map((name) => ({ name }));
  const xml = `<joint class="j" name="mcp"/><site\n name="tip" pos="0 0 0"/><geom name="pad"/>`;
  assert.equal(misfit(xml, names("mcp", "tip.x", "tip.y", "tip.z")), "");
  assert.equal(misfit(xml, names("mcp", "pad.x")), "pad.x");
  assert.equal(misfit(xml, names("tip.x", "pip")), "pip");
  assert.equal(misfit(xml, names("mcp.x")), "mcp.x");
});

test("numbers are as people read them", () => {
  assert.equal(quantity(0.0125, "m"), "12.5 mm");
  assert.equal(quantity(-Math.PI / 2, "rad"), "−90.0°");
  assert.equal(quantity(undefined, "N"), "–");
  assert.equal(number(-0.0001, 1), "0.0");
  assert.equal(howLong(7384), "2 h 3 min");
  assert.equal(howLong(0.4), "0 s");
  assert.equal(howLong(86400), "1 d");
});
