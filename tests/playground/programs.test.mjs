// The Python programs that the page gives repeat its runs.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { download, launch, open, runFor } from "./browser.mjs";
import { valuesOf } from "./python.mjs";

const CYLINDER = "PneumaticServoCylinder";
/** A drawing that does not begin at 0. */
const FALLING = Array.from({ length: 101 }, (_, point) => 500 - 7 * point).join(" ");
let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

/** Tolerance relative to the largest value: the page and NumPy round sines and times of steps differently. */
const TOLERANCE = 1e-9;

/**
 * A page with a setting, what its program has to show, and the column that this has to repeat: one that does not depend on
 * the input directly, since a row of the page has the input of the step that begins there, and one of the package that of
 * the step that ends.
 */
const RUNS = [
  ["stick-slip", `&${CYLINDER}.friction.law=14&${CYLINDER}.supplyPressure=600000`, 'run["position"]', "position"],
  ["stick-slip", "&signal=ramp&amplitude=3&period=0.3", 'run["frictionForce"]', "frictionForce"],
  ["two-laws", "&amplitude=3&period=0.3&second=16", 'second["position"]', "GMS.position"],
  ["two-laws", "&signal=drawn&amplitude=3&period=0.3&second=16", 'first["position"]', "Stribeck.position"],
  ["presliding", "&signal=drawn&FrictionBench.friction.law=15", 'run["position"]', "position"],
  ["presliding", `&signal=drawn&points=${FALLING}`, 'run["position"]', "position"],
  ["closed-loop", "&level=0.3&period=1&PositionController.gain.position=20", "position", "plant.position"],
];

for (const [view, fragment, shown, column] of RUNS) {
  test(`the program of ${view}${fragment.slice(0, 60)} gives ${column} of the page`, async () => {
    const { page, close } = await open(browser, `#view=${view}${fragment}`);
    if (view !== "presliding") await runFor(page, 0.4);
    const [csv, program] = [await download(page, "CSV"), await download(page, "Python")];
    await close();
    const found = await valuesOf(csv, `${program.text}\nimport json\nprint(json.dumps([float(x) for x in ${shown}]))\n`);
    const [head, ...rows] = csv.text.trimEnd().split("\n").map((line) => line.split(","));
    const expected = rows.map((row) => Number(row[head.indexOf(column)]));
    assert.ok(expected.length > 300 && new Set(expected).size > 100, `${expected.length} rows`);
    assert.equal(found.length, expected.length);
    const furthest = found.reduce((most, value, row) => Math.max(most, Math.abs(value - expected[row])), 0);
    const largest = expected.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
    assert.ok(furthest <= TOLERANCE * largest, `${furthest} apart, with values up to ${largest}`);
  });
}
