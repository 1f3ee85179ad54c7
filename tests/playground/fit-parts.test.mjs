// Parts of a fit by themselves: units, columns.
import assert from "node:assert/strict";
import { test } from "node:test";
import { part } from "./part.mjs";

/** The units of the library that these tests need. */
const unit = (name, si, factor, offset = 0) => ({ name, si, factor, offset });
const TABLES = {
  units: { m: { display: [{ name: "mm", factor: 1e3, offset: 0 }] }, Pa: { display: [{ name: "bar", factor: 1e-5, offset: 0 }] }, K: { display: [{ name: "degC", factor: 1, offset: -273.15 }] } },
  written: [
    ...[unit("m", "m", 1), unit("um", "m", 1e-6), unit("mm", "m", 1e-3), unit("s", "s", 1), unit("V", "V", 1), unit("degC", "K", 1, 273.15)],
    ...[unit("Pa", "Pa", 1), unit("bar", "Pa", 1e5), unit("barg", "Pa", 1e5, 101_325), unit("bara", "Pa", 1e5)],
  ],
  spellings: { parts: [[" ", ""], ["\u00b5", "u"], ["(g)", "g"]], whole: [["sec", "s"]] },
};
const near = (found, expected, within) => assert.ok(Math.abs(found - expected) <= within, `${found} is not ${expected}`);

test("values are turned into SI units, as exactly as they are written", async () => {
  const { toSi, unitsOf, plain, typedAs } = await part("units");
  const { typed } = await part("typed");
  const si = (value, unit, of, turned = false) => toSi(Float64Array.of(value), unitsOf(TABLES, of).get(unit), turned)[0];
  assert.equal(si(250, "mm", "m"), 0.25);
  assert.equal(si(250.061, "mm", "m"), 250.061 / 1000);
  assert.equal(si(3, "um", "m"), 3 / 1e6);
  near(si(6, "bar", "Pa"), 6e5, 1e-9);
  assert.equal(si(1, "barg", "Pa"), 201_325);
  assert.equal(si(20, "degC", "K"), 293.15);
  assert.equal(si(2, "m", "m", true), -2);
  const own = (text) => plain(TABLES.spellings, text);
  assert.deepEqual([own(" \u00b5m"), own("sec")], ["um", "s"]);
  assert.deepEqual([...unitsOf(TABLES, "m").keys()].slice(0, 2), ["m", "mm"]);
  const bar = { name: "bar", factor: 1e-5, offset: 0 };
  for (const [text, value] of [["6 barg", 7.01325], ["6 bar (g)", 7.01325], ["600000 Pa", 6], ["6", 6]]) {
    near(typed(text, "bar", typedAs(TABLES, "Pa", bar), own), value, 1e-12);
  }
  near(typed("20 degC", "K", typedAs(TABLES, "K", { name: "K", factor: 1, offset: 0 })), 293.15, 1e-12);
});
