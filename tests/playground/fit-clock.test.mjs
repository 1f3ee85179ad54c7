// A record whose clock is wrong: the verdict of the page names the clock and its size, as the Python package does.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, test } from "node:test";
import { download, launch, open } from "./browser.mjs";
import { drop, fitted, LINK, RIG } from "./fits.mjs";
import { valuesOf } from "./python.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

const FAST = 1.01;

/** The clock in the sentence that names it. */
const clock = (sentence) => Number(/would be gone if time were ([\d.]+) \[[\d.]+, [\d.]+\] times what was recorded/.exec(sentence)?.[1]);

test("a clock that runs 1 % fast is named with its size beside the traffic light", async () => {
  const [head, ...rows] = (await readFile(RIG, "utf8")).trimEnd().split("\n");
  const fast = rows.map((row) => row.replace(/^[^,]+/, (time) => (FAST * Number(time)).toFixed(6)));
  const text = `${[head, ...fast].join("\n")}\n`;
  const { page, close } = await open(browser, LINK);
  await drop(page, "rig.csv", text);
  await page.waitForSelector("table.columns");
  await fitted(page);
  assert.equal(await page.locator("[data-result]").getAttribute("data-light"), "yellow");
  const sentence = await page.locator("[data-result] [data-cause]").textContent();
  const program = await download(page, "Python");
  await close();
  assert.ok(Math.abs(clock(sentence) * FAST - 1) < 1e-3, sentence);
  const [light, told] = await valuesOf({ name: "rig.csv", text }, `${program.text}\nimport json\nprint(json.dumps([found.verdict.light, str(found.suspect)]))\n`);
  assert.equal(light, "yellow");
  assert.ok(Math.abs(clock(told) - clock(sentence)) < 1e-4, `${told}, not ${sentence}`);
});
