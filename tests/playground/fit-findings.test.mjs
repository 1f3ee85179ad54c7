// Findings about a record before it is fitted, and the buttons that follow their remedies.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, test } from "node:test";
import { download, launch, open } from "./browser.mjs";
import { button, CYLINDER, drop, fitted, LINK, RIG } from "./fits.mjs";
import { valuesOf } from "./python.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

const findings = (page) => page.locator("[data-finding]");
const remedy = (page, name) => findings(page).getByRole("button", { name, exact: true }).first();
/** Waits until no finding about a signal is left. */
const gone = (page, signal) => page.locator(`[data-finding="${signal}"]`).waitFor({ state: "detached" });

/** The rig with other numbers in its columns, t, u, x_mm, pa_bar and pb_bar, under names that tell no unit. */
async function changed(page, change, header = "t,u,x [mm],pA [bar],pB [bar]") {
  const [, ...rows] = (await readFile(RIG, "utf8")).trimEnd().split("\n");
  const text = [header, ...rows.map((row) => change(row.split(",").map(Number)).join(","))].join("\n");
  await drop(page, "rig.csv", text);
  await page.waitForSelector("table.columns");
  return text;
}

test("pressures that count from the atmosphere prevent a fit until their unit says so", async () => {
  const { page, close } = await open(browser, LINK);
  await changed(page, ([t, u, x, a, b]) => [t, u, x, (a - 1.01325).toFixed(5), (b - 1.01325).toFixed(5)]);
  await page.locator('[data-finding="chamberA.pressure"]').waitFor();
  assert.deepEqual(await findings(page).evaluateAll((all) => all.map(({ dataset }) => dataset.finding)), ["chamberA.pressure", "chamberB.pressure"]);
  assert.match(await findings(page).first().textContent(), /chamberA\.pressure \(column pA in bar\) is from .* do these count from the atmosphere\?/);
  assert.equal(await button(page).isDisabled(), true);
  await page.locator("p.muted").filter({ hasText: "do these count from the atmosphere?" }).waitFor();
  for (const signal of ["chamberA.pressure", "chamberB.pressure"]) {
    await page.locator(`[data-finding="${signal}"]`).getByRole("button", { name: "Take it as bar above the atmosphere" }).click();
    await gone(page, signal);
    assert.equal(await page.getByLabel(`Unit of ${signal}`).inputValue(), "barg");
  }
  assert.equal(await button(page).isDisabled(), false);
  await close();
});

test("a position in mm, or turned, is taken as it is meant", async () => {
  const { page, close } = await open(browser, LINK);
  await changed(page, (row) => row, "t,u,x,pA [bar],pB [bar]");
  await page.locator('[data-finding="position"]').waitFor();
  assert.match(await findings(page).textContent(), /but cylinder\.stroke = 0\.5 m, which is its default; is it in mm, 0\.0\d+ to 0\.3\d+ m\?/);
  await remedy(page, "Take it in mm").click();
  await gone(page, "position");
  assert.equal(await page.getByLabel("Unit of position").inputValue(), "mm");

  await changed(page, ([t, u, x, ...others]) => [t, u, -x, ...others]);
  await remedy(page, "Turn the sign of position").click();
  await gone(page, "position");
  assert.equal(await page.getByLabel("Turn the sign of position").isChecked(), true);
  await close();
});

test("swapped chambers are doubted, and a voltage in percent is corrected, in the program for Python too", async () => {
  const { page, close } = await open(browser, `${LINK}&${CYLINDER}.valve.C=4.4e-9`.replace(/free=[^&]*/, "free=friction.stribeck.Fc"));
  await changed(page, ([t, u, x, a, b]) => [t, 10 * u, x, b, a]);
  await page.locator('[data-finding="chamberA.pressure"]').waitFor();
  assert.equal(await button(page).isDisabled(), false, "a doubt does not prevent a fit");
  await remedy(page, "Swap the chambers").click();
  await gone(page, "chamberA.pressure");
  assert.equal(await page.getByLabel("Column of chamberA.pressure").inputValue(), "4");
  await remedy(page, "Set gain.valveVoltage = 0.1").click();
  await gone(page, "valveVoltage");
  await page.getByText("Corrected readings: gain.valveVoltage = 0.1").waitFor();
  assert.equal(await findings(page).count(), 0);
  await fitted(page);
  const program = await download(page, "Python");
  assert.match(program.text, /"gain\.valveVoltage": 0\.1,/);
  assert.match((await download(page, "SSV")).text, /friction\.stribeck\.Fc/);
  await page.getByRole("button", { name: "Take them as they are" }).click();
  await page.locator('[data-finding="valveVoltage"]').waitFor();
  await close();
});

test("rows that a recorder has repeated are left out, in the program for Python too", async () => {
  const { page, close } = await open(browser, LINK);
  let [row, last] = [0, []];
  const text = await changed(page, (own) => {
    row += 1;
    last = row % 10 === 0 ? [own[0], ...last.slice(1)] : own;
    return last;
  });
  await page.locator('[data-finding="time"]').waitFor();
  // Some rows of the rig repeat the one before by chance.
  await page.getByRole("button", { name: /^Leave these 3\d\d rows out$/ }).click();
  await gone(page, "time");
  await page.getByText(/3\d\d rows left out/).waitFor();
  const found = await fitted(page);
  const program = await download(page, "Python");
  const shown = "import json; print(json.dumps([[e.value, e.low, e.high] for e in found.parameters.values()]))";
  const expected = await valuesOf({ name: "rig.csv", text }, `${program.text}\n${shown}\n`);
  for (const [place, { value, low, high }] of [...found.values()].entries()) {
    const [own, least, most] = expected[place];
    assert.ok(Math.abs(value - own) < 1e-3 * (most - least) && low < own && own < high, `${value} is not ${own} [${least}, ${most}]`);
  }
  await page.getByRole("button", { name: "Take them as they are" }).click();
  await page.locator('[data-finding="time"]').waitFor();
  await close();
});

test("a sample that is far off is named by its line", async () => {
  const { page, close } = await open(browser, LINK);
  let row = 1;
  await changed(page, ([t, u, x, ...others]) => [t, u, (row += 1) === 700 ? 99999 : x, ...others]);
  await page.locator('[data-finding="position"]').waitFor();
  assert.match(await findings(page).textContent(), /rig\.csv:700, column 3 \(x\) = 99\.999 m\. Correct or remove the sample in the table\./);
  assert.equal(await button(page).isDisabled(), true);
  await remedy(page, "Leave this row out").click();
  await gone(page, "position");
  assert.equal(await button(page).isDisabled(), false);
  await close();
});
