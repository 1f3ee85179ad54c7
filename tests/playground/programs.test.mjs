// The Python programs that the page gives repeat its runs.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { download, launch, open, reached } from "./browser.mjs";
import { valuesOf } from "./python.mjs";

const CYLINDER = "PneumaticServoCylinder";
/** A drawing that does not begin at 0. */
const FALLING = Array.from({ length: 101 }, (_, point) => 500 - 7 * point).join(" ");
let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

/** Relative to the largest value: the package interpolates the inputs of a run, which moves last bits. */
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

/** Compares a column of a file with the list that the program beside it makes. */
async function repeats(csv, program, shown, column) {
  assert.equal(program.name, csv.name.replace(/csv$/, "py"));
  const found = await valuesOf(csv, `${program.text}\nimport json\nprint(json.dumps([float(x) for x in ${shown}]))\n`);
  const [head, ...rows] = csv.text.trimEnd().split("\n").map((line) => line.split(","));
  const expected = rows.map((row) => Number(row[head.indexOf(column)]));
  assert.ok(expected.length > 300 && new Set(expected).size > 100, `${expected.length} rows`);
  assert.equal(found.length, expected.length);
  const furthest = found.reduce((most, value, row) => Math.max(most, Math.abs(value - expected[row])), 0);
  const largest = expected.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  assert.ok(furthest <= TOLERANCE * largest, `${furthest} apart, with values up to ${largest}`);
}

for (const [view, fragment, shown, column] of RUNS) {
  test(`the program of ${view}${fragment.slice(0, 60)} gives ${column} of the page, exported while it runs`, async () => {
    const { page, close } = await open(browser, `#view=${view}${fragment}`);
    if (view !== "presliding") await reached(page, 0.4);
    const csv = await download(page, "CSV");
    await page.waitForTimeout(300);
    const program = await download(page, "Python");
    await close();
    await repeats(csv, program, shown, column);
  });
}

for (const [view, shown, column] of [
  ["stick-slip", 'run["position"]', "position"],
  ["two-laws", 'second["position"]', "SmoothCoulomb.position"],
  ["closed-loop", "position", "plant.position"],
]) {
  test(`the program of ${view} repeats changes of parameters, inputs and the signal under way`, async () => {
    const { page, close } = await open(browser, `#view=${view}`);
    const put = async (label, text) => {
      await page.getByLabel(`${label}, value`, { exact: true }).fill(text);
      await page.keyboard.press("Enter");
    };
    await reached(page, 0.2);
    await put("Supply", "6.5 bar");
    await reached(page, 0.4);
    await put("Supply", "5 bar");
    await put("Amplitude", view === "closed-loop" ? "60 mm" : "2 V");
    if (view === "closed-loop") await put("Position gain", "25");
    await reached(page, 1.6);
    const program = await download(page, "Python");
    const csv = await download(page, "CSV");
    await close();
    assert.match(program.text, /"supplyPressure": 500000/);
    await repeats(csv, program, shown, column);
  });
}

test("of a run of more than two minutes no program is given, but a remedy", async () => {
  const { page, close } = await open(browser, "#view=stick-slip");
  await page.getByRole("button", { name: "60:1" }).click();
  await reached(page, 121);
  const refused = page.waitForFunction(() => /Restart, and export/.test(document.querySelector("#problem").textContent));
  await page.locator("#files").getByRole("button", { name: "Python" }).click();
  await refused;
  // The record is cut at its begin; how often depends on how long the clicks took at this speed.
  assert.match((await download(page, "CSV")).text.split("\n")[1], /^[1-9]\d*,/);
  await page.getByRole("button", { name: "Restart" }).click();
  assert.match((await download(page, "Python")).name, /\.py$/);
  await close();
});
