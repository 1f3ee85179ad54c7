// Measured friction from a table: the page reads and refuses it as the Python package does, and its program repeats the run.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { download, launch, open, runFor } from "./browser.mjs";
import { drop } from "./fits.mjs";
import { valuesOf } from "./python.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

const CYLINDER = "PneumaticServoCylinder";
const FILE = "friction.csv";
const PLACE = ".drop:has([aria-label='Open measured friction'])";

/** Both directions, in any order, with decimal commas and units of their own. */
const FEW = "Recorder 7;serial 12\nGeschwindigkeit [mm/s];Reibung (N)\n200;14,5\n20;9\n0;11\n100;10,25\n-10;-12\n-50;-9,5\n-250;-16\n";

/** Samples of a recorder, which become eleven points. */
function many() {
  const rows = Array.from({ length: 3000 }, (_, row) => {
    const speed = 0.3 * Math.sin(row * 0.01);
    return `${speed.toFixed(6)},${(Math.sign(speed) * (8 + 3 * Math.exp(-Math.abs(speed) / 0.04)) + 20 * speed + 0.2 * Math.sin(row * row)).toFixed(5)}`;
  });
  return `v,F\n${rows.join("\n")}\n`;
}

const shown = (page) => page.locator("[data-curve]").textContent();
const told = (page) => page.locator("[data-curve-problem]").textContent();

/** Drops a table, and waits until it is taken or refused. */
async function take(page, text) {
  const before = await Promise.all([shown(page), told(page)]);
  await drop(page, FILE, text, PLACE);
  await page.waitForFunction(
    ([curve, problem]) =>
      document.querySelector("[data-curve]").textContent !== curve || document.querySelector("[data-curve-problem]").textContent !== problem,
    before,
  );
}

/** Settings of the law in the address, which are those that are not the defaults. */
async function settings(page) {
  await page.waitForTimeout(500);
  const link = new URLSearchParams(new URL(page.url()).hash.slice(1));
  const own = [...link].filter(([name]) => name.startsWith(`${CYLINDER}.friction.`));
  return new Map(own.map(([name, value]) => [name.slice(CYLINDER.length + 1), Number(value)]));
}

for (const [title, text] of [["few points", FEW], ["samples", many()]]) {
  test(`${title}: the settings are those of ps.friction_table, and the program of the page repeats its run`, async () => {
    const { page, close } = await open(browser, "#view=stick-slip&signal=ramp&amplitude=3&period=0.3");
    await page.getByText("Measured friction").click();
    await take(page, text);
    assert.equal(await page.locator("#problem").isVisible(), false);
    assert.match(await page.getByLabel("Friction law", { exact: true }).evaluate((select) => select.selectedOptions[0].textContent), /^Table:/);
    await page.waitForTimeout(300);
    const ink = await page.locator(".curve canvas").evaluate((chart) => {
      const { data } = chart.getContext("2d").getImageData(0, 0, chart.width, chart.height);
      return data.reduce((sum, value, index) => sum + (index % 4 === 3 && value > 0), 0);
    });
    assert.ok(ink > 1000, `${ink} pixels`);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 1280, "the card fits beside the plant");

    const own = await settings(page);
    const defaults = "{name: v.default for name, v in ps.Model().parameters.items() if name.startswith('friction.table.')}";
    const python = `import json, pneumatic_servo as ps\nfound = {**${defaults}, **ps.friction_table("${FILE}")}\nprint(json.dumps([[n, v, str(ps.Model().parameters[n].default)] for n, v in found.items()]))`;
    const expected = await valuesOf({ name: FILE, text }, python);
    assert.ok(expected.length > 40);
    for (const [name, value, start] of expected) {
      if (name === "friction.law") assert.equal(value, "Table");
      else assert.equal(own.get(name) ?? Number(start), value, name);
    }

    await runFor(page, 0.4);
    const [csv, program] = [await download(page, "CSV"), await download(page, "Python")];
    const found = await valuesOf(csv, `${program.text}\nimport json\nprint(json.dumps([float(x) for x in run["position"]]))\n`);
    const [head, ...rows] = csv.text.trimEnd().split("\n").map((line) => line.split(","));
    const positions = rows.map((row) => Number(row[head.indexOf("position")]));
    assert.ok(positions.length === found.length && new Set(positions).size > 100, `${positions.length} rows`);
    for (const [row, position] of positions.entries()) assert.ok(Math.abs(found[row] - position) < 1e-9, `${found[row]} m in row ${row}, not ${position}`);
    await close();
  });
}

test("a second table leaves nothing of the first, and the link restores it", async () => {
  const { page, close } = await open(browser, "#view=stick-slip");
  await page.getByText("Measured friction").click();
  await take(page, many());
  await take(page, FEW);
  assert.match(await shown(page), /^friction\.csv: 7 rows\. 4 points outwards from 0 to 200 mm\/s, breaking away at 11 N\. 3 points inwards from 10 to 250 mm\/s/);
  const own = await settings(page);
  assert.equal(own.get("friction.table.outwards.speed[4]"), 0.2);
  assert.equal(own.has("friction.table.outwards.speed[5]"), false);
  const { page: other, close: closeOther } = await open(browser, new URL(page.url()).hash);
  assert.match(await shown(other), /^4 points outwards from 0 to 200 mm\/s/);
  await closeOther();
  await close();
});

test("a table that is no curve is refused in the words of Python, and changes nothing", async () => {
  const { page, close } = await open(browser, "#view=presliding");
  await page.getByText("Measured friction").click();
  const law = await page.getByLabel("Friction law", { exact: true }).inputValue();
  for (const [text, words] of [
    ["v [m/s],F [N]\n0,11\n0.1,abc\n", /friction\.csv:3, column 2 \(F\): 'abc' is no number/],
    ["v,F\n0,11\n0.1,nan\n", /friction\.csv:3, column 2 \(F\): nan is not finite/],
    ["v,F\n0,11\n0.1\n", /friction\.csv:3: 1 values, but the header has 2 columns/],
    ["t,F\n0,11\n0.1,9\n", /has the columns t, F: one of them must be velocity/],
    ["v,F,friction\n0,11,11\n0.1,9,9\n", /has 2 columns of force, F, friction/],
    ["v,F [kg]\n0,11\n0.1,9\n", /friction\.csv:1, column 2 \(F\): the unit kg is refused; it must be one of N, daN, kN, mN, lbf/],
    ["v,F\n0.1,11\n0.1,9\n", /friction\.csv:2: the friction outwards has one velocity, 0\.1 m\/s: a curve needs two/],
    ["v,F\n0,11\n0.1,9\n-0.1,-9\n0.2,-4\n", /friction\.csv:5: the friction outwards, -4 N at 0\.2 m\/s, drives/],
  ]) {
    await take(page, text);
    const problem = await told(page);
    assert.match(problem, words);
    const python = `import json, pneumatic_servo as ps\ntry:\n    ps.friction_table("${FILE}")\nexcept ValueError as error:\n    print(json.dumps(str(error)))`;
    assert.equal(problem, await valuesOf({ name: FILE, text }, python));
    assert.equal(await page.getByLabel("Friction law", { exact: true }).inputValue(), law);
  }
  await page.getByRole("tab", { name: "Fit", exact: true }).click();
  assert.equal(await page.getByText("Measured friction").count(), 0);
  await close();
});
