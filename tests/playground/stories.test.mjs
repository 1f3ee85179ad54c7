// The balance of forces, and each story: it shows what it says, by numbers of its run.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { download, launch, open, runFor } from "./browser.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

const CYLINDER = "PneumaticServoCylinder";

/** Columns of the run so far. */
async function columns(page) {
  const [head, ...rows] = (await download(page, "CSV")).text.trimEnd().split("\n").map((line) => line.split(","));
  return (name) => rows.map((row) => Number(row[head.indexOf(name)]));
}

/** Opens a story by its link, as fast as the machine can. */
async function told(key, seconds) {
  const { page, close } = await open(browser);
  await page.locator(`[data-story="${key}"]`).click();
  await page.waitForFunction((wanted) => document.querySelector(`[data-story="${wanted}"]`).hasAttribute("aria-current"), key);
  assert.match(await page.locator("#watch").textContent(), /^Watch: .*Next$/);
  assert.equal(await page.locator("#problem").isVisible(), false);
  assert.equal(await page.locator(".chart.watched").count(), 1, "a chart is marked");
  if (seconds) {
    await page.getByRole("button", { name: "60:1" }).click();
    await runFor(page, seconds);
  }
  return { page, close };
}

const breakAways = (sticking) => sticking.filter((held, row) => row > 0 && sticking[row - 1] === 1 && held === 0).length;

/** Error of the loop in mm over its last seconds: RMS and at the end, with the break-aways. */
async function loop(page, seconds) {
  const of = await columns(page);
  const last = (name) => of(name).slice(-1000 * seconds);
  const [wanted, is] = ["controller.referencePosition", "plant.position"].map(last);
  const errors = wanted.map((value, row) => 1e3 * (value - is[row]));
  const rms = Math.sqrt(errors.reduce((sum, error) => sum + error ** 2, 0) / errors.length);
  return { rms, end: errors.at(-1), breakAways: breakAways(last("plant.sticking")), range: Math.max(...errors) - Math.min(...errors) };
}

test("the carriage sticks while the resultant lies inside the band, whose ends are those of the plant", async () => {
  const { page, close } = await open(browser, "#view=stick-slip&signal=constant&level=5.2");
  await runFor(page, 0.4);
  const ends = () => page.locator(".hold .end:visible").allTextContents();
  assert.deepEqual(await ends(), ["−11.0 N", "11.0 N"]);
  assert.match(await page.locator(".told").textContent(), /^Resultant −?[\d.]+ N inside the band: it sticks$/);
  const within = await page.evaluate(() => {
    const [band, bar] = [".hold .band", ".hold .resultant"].map((name) => document.querySelector(name).getBoundingClientRect());
    return band.left <= bar.left && bar.right <= band.right;
  });
  assert.ok(within);
  const of = await columns(page);
  const [sticking, chambers, friction] = ["sticking", "pressureForce", "frictionForce"].map(of);
  assert.ok(sticking.includes(1) && sticking.every((held, row) => held === 0 || (Math.abs(chambers[row]) <= 11 && Math.abs(chambers[row] - friction[row]) < 1e-9)));
  await close();
  // With a load level that grows with pressure.
  const loaded = await open(browser, `#view=stick-slip&signal=constant&level=5&${CYLINDER}.chamberA.pressure0=301325&${CYLINDER}.friction.kappaA=1e-6`);
  await runFor(loaded.page, 0.1);
  const pressure = (await columns(loaded.page))("chamberA.pressure").at(-1);
  await loaded.page.waitForTimeout(300);
  const [, high] = await loaded.page.locator(".hold .end:visible").allTextContents();
  const expected = 11 * (1 + 1e-6 * (pressure - 101_325));
  assert.ok(Math.abs(Number.parseFloat(high) - expected) < 0.06 && expected > 11.2, `${high}, not ${expected} N`);
  await loaded.close();
});

test("a law without a static level has no band, and the page says so", async () => {
  const { page, close } = await open(browser, `#view=stick-slip&${CYLINDER}.friction.law=14`);
  await runFor(page, 0.3);
  assert.equal(await page.locator(".hold .band:visible").count(), 0);
  assert.match(await page.locator(".told").textContent(), /LuGre has no band$/);
  await close();
});

test("push it: 10 N do not move it, 12 N do", async () => {
  const { page, close } = await told("push");
  const drawing = await page.locator(".cylinder").evaluate((one) => one.getScreenCTM().a);
  const carriage = await page.locator(".carriage").boundingBox();
  const middle = [carriage.x + carriage.width / 2, carriage.y + carriage.height / 2];
  await page.mouse.move(...middle);
  await page.mouse.down();
  const pull = async (force) => {
    await page.mouse.move(middle[0] + (force / 0.25) * drawing, middle[1], { steps: 4 });
    await page.waitForTimeout(700);
    return Number.parseFloat(await page.locator(".readouts dd").first().textContent());
  };
  const [held, moved] = [await pull(10), await pull(12)];
  await page.mouse.up();
  assert.equal(held, 250);
  assert.ok(moved > 255, `${moved} mm`);
  await close();
});

test("it sticks at every reversal", async () => {
  const { page, close } = await told("reversal", 12.5);
  const of = await columns(page);
  const [sticking, position] = ["sticking", "position"].map(of);
  // Two reversals in each period of 4 s.
  const rests = breakAways(sticking.slice(-8000));
  assert.ok(rests >= 4, `${rests} rests in two periods`);
  assert.ok(Math.max(...position) - Math.min(...position) > 0.03);
  await close();
});

test("a slow ramp is a staircase, which vanishes where Fs = Fc", async () => {
  const steps = [];
  for (const key of ["staircase", "equal"]) {
    const { page, close } = await told(key, 13);
    steps.push((await loop(page, 8)).breakAways);
    await close();
  }
  assert.ok(steps[0] >= 10 && steps[1] <= 4, `${steps} break-aways`);
});

test("P alone stops 0.67 mm short, an integral part hunts", async () => {
  const short = await told("short", 22);
  const { end, range } = await loop(short.page, 4);
  assert.ok(Math.abs(end - 0.673) < 0.005 && range === 0, `${end} mm, range ${range}`);
  await short.close();
  const hunt = await told("hunt", 16.5);
  const hunting = await loop(hunt.page, 8);
  assert.ok(Math.abs(hunting.rms - 1.35) < 0.1 && hunting.breakAways > 15 && hunting.range > 2, JSON.stringify(hunting));
  await hunt.close();
  const smooth = await told("smooth", 16.5);
  const hidden = await loop(smooth.page, 8);
  assert.ok(hidden.breakAways === 0 && hidden.rms < 0.75 * hunting.rms, JSON.stringify(hidden));
  await smooth.close();
});

test("dither cures hunting, and the cures stand side by side", async () => {
  const { page, close } = await told("cures", 16.5);
  const cured = await loop(page, 8);
  assert.ok(cured.rms < 0.02 && cured.range < 0.05, JSON.stringify(cured));
  assert.match((await download(page, "Python")).text, /controller\["valveVoltage"\] \+ \(1 if row \/\/ 20 % 2 == 0 else -1\)/);
  await page.getByRole("button", { name: "Compare" }).click();
  await page.waitForFunction(() => document.querySelectorAll(".cures td:not(:empty)").length === 8);
  const cells = await page.locator(".cures tbody tr").evaluateAll((rows) => rows.map((row) => [...row.cells].map((cell) => Number.parseFloat(cell.textContent))));
  const [none, compensated, stopped, dithered] = cells.map(([, rms, swing]) => ({ rms, swing }));
  assert.ok(none.rms > 2 && compensated.rms < none.rms / 2 && compensated.swing > 1, JSON.stringify(cells));
  assert.ok(stopped.swing === 0 && stopped.rms > 0.5 && dithered.swing < 0.05 && dithered.rms < 0.02, JSON.stringify(cells));
  await page.getByLabel("Dither").uncheck();
  await page.getByLabel("Integral stop").check();
  await page.waitForURL(/integralStop=0\.001/);
  await close();
});

test("a smooth law creeps under a load that Stribeck holds", async () => {
  const { page, close } = await told("creep", 8);
  const of = await columns(page);
  const moved = ["Stribeck", "SmoothCoulomb"].map((law) => 1e3 * (of(`${law}.position`).at(-1) - of(`${law}.position`)[0]));
  assert.ok(moved[0] === 0 && moved[1] > 10, `${moved} mm`);
  await close();
});

test("Next goes through all stories and back to the first", async () => {
  const { page, close } = await open(browser);
  const stories = await page.locator("[data-story]").evaluateAll((all) => all.map((one) => one.dataset.story));
  await page.locator("[data-story]").first().click();
  for (const key of [...stories.slice(1), stories[0]]) {
    await page.locator("#watch .next").click();
    await page.waitForFunction((wanted) => document.querySelector("[aria-current]").dataset.story === wanted, key);
    assert.equal(await page.locator("#problem").isVisible(), false, key);
  }
  await page.getByRole("tab", { name: "Race" }).click();
  assert.equal(await page.locator("#watch").isVisible(), false);
  await close();
});
