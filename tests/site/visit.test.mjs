// Pages of the site, as a visitor finds them in Chromium.
import assert from "node:assert/strict";
import { readFileSync, statSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { after, before, test } from "node:test";
import { launch, open, pages, plant } from "./site.mjs";
import { WORDS } from "./words.mjs";

const AXE = readFileSync(fileURLToPath(import.meta.resolve("axe-core/axe.min.js")), "utf8");
/** In bytes: what the landing page may weigh before the plant is asked for. */
const LIGHT = 300_000;

/** One page of each kind, which axe looks at; `EVERY_PAGE=1` has it look at all, which takes minutes. */
const KINDS = [
  "index.html",
  "CHANGELOG.html",
  "gallery.html",
  "laws/VelocityBased.html",
  "laws/index.html",
  "search.html",
  "docs/start/python.html",
  "docs/friction-laws.html",
  "docs/performance.html",
  "docs/tutorial/tutorial.html",
  "models/FrictionBench.html",
  "reference/command-line.html",
  "reference/python/models.html",
  "reference/rust.html",
];

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

/** Serious findings of axe. */
async function findings(page) {
  await page.evaluate(AXE);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"], iframes: false, preload: false }));
  return violations
    .filter(({ impact }) => impact === "serious" || impact === "critical")
    .flatMap(({ id, nodes }) => nodes.slice(0, 3).map((node) => `${id}: ${node.html.slice(0, 200)} ${node.any[0]?.message ?? ""}`));
}

test("every page opens without an error and fits on 400 pixels, and none of each kind keeps people out", async () => {
  const names = await pages();
  assert.ok(names.length > 30, String(names.length));
  assert.deepEqual(KINDS.filter((name) => !names.includes(name)), []);
  const found = [];
  for (const name of names) {
    // Half of the pages each way: the colours come from the same style sheets.
    const colorScheme = names.indexOf(name) % 2 ? "dark" : "light";
    const { page, close } = await open(browser, name, { colorScheme, viewport: { width: 400, height: 800 } });
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    if (width > 400) found.push(`${name} is ${width} pixels wide`);
    if (name !== "search.html" && (await page.locator('meta[name="description"]').count()) !== 1) found.push(`${name} has not one description`);
    if (KINDS.includes(name) || process.env.EVERY_PAGE) {
      found.push(...(await findings(page)).map((finding) => `${name}, ${colorScheme}: ${finding}`));
    }
    await close();
  }
  assert.deepEqual(found, []);
});

test("the landing page is light until the plant is asked for", async (context) => {
  const { asked, close } = await open(browser, "index.html");
  const own = [...asked].filter((file) => !file.endsWith("playground.html"));
  const bytes = own.reduce((sum, file) => sum + statSync(file).size, 0);
  assert.ok(own.length > 3 && bytes < LIGHT, `${bytes} bytes: ${own}`);
  context.diagnostic(`${bytes} bytes in ${own.length} files`);
  await close();
});

test("the plant runs on the landing page, in its colours and without a bar to scroll", async () => {
  const { page, close } = await open(browser, "index.html", { colorScheme: "light" });
  const frame = await plant(page);
  await frame.waitForFunction(() => Number(document.querySelector("[data-status]").dataset.time) > 0.2);
  const back = () => frame.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await back();
  // Furo's button goes from the system's choice to the next.
  for (let press = 0; press < 3 && (await back()) === light; press += 1) {
    await page.locator(".theme-toggle:visible").first().click();
    await page.waitForTimeout(200);
  }
  assert.notEqual(await back(), light);
  await page.waitForFunction(() => document.getElementById("plant").clientHeight > 500);
  const hidden = await frame.evaluate(() => document.documentElement.scrollHeight - innerHeight);
  assert.ok(hidden <= 1, `${hidden} pixels are out of sight`);
  await close();
});

/** Searches and the pages of which one comes first: words of the field, in the text or not. */
const FIRST = [
  ["stiction", "docs/friction-laws.html", "docs/stick-slip.html"],
  ["hunting", "docs/stick-slip.html"],
  ["PWM", "docs/parameters.html"],
  ["solenoid", "docs/machines.html"],
  ["5/2", "docs/machines.html"],
  ["gravity", "docs/machines.html"],
  ["spring return", "docs/machines.html", "docs/parameters.html"],
  ["deadZone", "docs/parameters.html"],
  ["valve.C", "docs/parameters.html"],
  ["Cv", "docs/data-sheets.html"],
  ["real time", "docs/realtime.html"],
  ["Matlab", "docs/tools/simulink.html"],
  ["LuGre", "laws/LuGre.html"],
  ["state events", "docs/solver.html"],
  ["simulate_many", "reference/python/models.html"],
  ["Setup", "docs/start/rust.html"],
];

test("the search ranks without a server, and shows where the words stand", async () => {
  const wrong = [];
  const { page, close } = await open(browser, "index.html");
  for (const [words, ...expected] of FIRST) {
    await page.locator(".sidebar-search").first().fill(words);
    await page.keyboard.press("Enter");
    await page.waitForURL(/search\.html/);
    const first = page.locator("#search-results > li").first();
    await first.waitFor();
    const link = await first.locator("a").first().getAttribute("href");
    if (!expected.some((page) => link.includes(page))) wrong.push(`${words}: ${link}`);
    assert.ok((await first.locator(".excerpt mark").count()) > 0, `${words}: nothing is marked`);
  }
  assert.deepEqual(wrong, []);
  await page.locator("#search-results > li a").first().click();
  await page.waitForURL(/docs\/start\/rust\.html/);
  await close();
});

test("nine of ten words that people search for help at the first hit", async (context) => {
  const { page, close } = await open(browser, "search.html");
  const wrong = [];
  for (const [word, ...expected] of WORDS) {
    await page.locator("#search-words").fill(word);
    const links = await page.locator("#search-results > li > a").evaluateAll((all) => all.map((one) => one.getAttribute("href")));
    if (!expected.some((wanted) => links[0]?.includes(wanted))) wrong.push(`${word}: ${links[0] ?? "nothing"}`);
  }
  context.diagnostic(wrong.join("; "));
  assert.ok(WORDS.length >= 100 && wrong.length <= 0.1 * WORDS.length, `${wrong.length} of ${WORDS.length}: ${wrong.join("; ")}`);
  await close();
});

test("the search lists what was changed after what is, takes words as they are typed, and says when it finds nothing", async () => {
  const { page, close } = await open(browser, "search.html");
  const field = page.locator("#search-words");
  const links = () => page.locator("#search-results > li > a").evaluateAll((all) => all.map((one) => one.getAttribute("href")));
  await field.fill("bar");
  const found = await links();
  assert.ok(found.length > 5 && found.slice(0, 5).every((link) => /(docs|reference)\//.test(link)), String(found));
  await field.fill("<b>x</b> (q. [");
  await field.fill("zzqqxx");
  assert.match(await page.locator("#search-count").textContent(), /^No pages for/);
  assert.deepEqual(await links(), []);
  await close();
});

test("no two entries of the side bar have one name", async () => {
  const { page, close } = await open(browser, "index.html");
  const names = await page.locator(".sidebar-tree a.reference").evaluateAll((all) => all.map((one) => one.textContent.trim().toLowerCase()));
  assert.ok(names.length > 30, String(names.length));
  assert.deepEqual(names.filter((name, place) => names.indexOf(name) !== place), []);
  await close();
});

test("each law has a page with its curves, and those are shown that have what is wanted", async () => {
  const { page, close } = await open(browser, "laws/index.html");
  const shown = () => page.locator("#laws tbody tr:visible a").allTextContents();
  const all = await shown();
  assert.ok(all.length > 20, String(all));
  const known = await pages();
  assert.deepEqual(all.filter((law) => !known.includes(`laws/${law}.html`)), []);
  await page.getByLabel("sticks exactly").check();
  const exact = await shown();
  assert.ok(exact.includes("Stribeck") && !exact.includes("SmoothCoulomb") && !exact.includes("LuGre"), String(exact));
  await page.getByLabel("sticks exactly").uncheck();
  await page.getByLabel("nested loops close").check();
  await page.getByLabel("peak at break-away").check();
  assert.deepEqual((await shown()).sort(), ["GMS", "Leuven"]);
  await page.locator("#laws tbody tr:visible a").first().click();
  await page.waitForURL(/laws\/(GMS|Leuven)\.html/);
  const widths = await page.locator(".law-plots img").evaluateAll(async (all) => {
    for (const one of all) one.loading = "eager";
    await Promise.all(all.map((one) => one.decode()));
    return all.map((one) => one.naturalWidth);
  });
  assert.ok(widths.length >= 3 && widths.every((width) => width > 100), String(widths));
  // The link opens the playground under this law.
  await page.getByRole("link", { name: "Feel it stick and slip" }).click();
  await page.waitForSelector("html[data-ready]");
  assert.ok(["15", "16"].includes(await page.getByLabel("Friction law").inputValue()));
  await close();
});

test("a visitor without a mouse gets into the text and to every starting point", async () => {
  const { page, close } = await open(browser, "index.html");
  await page.keyboard.press("Tab");
  assert.match(await page.evaluate(() => document.activeElement.textContent), /skip to content/i);
  const starts = await page.locator(".starts a").count();
  assert.equal(starts, 5);
  await page.locator(".starts a").first().focus();
  await page.keyboard.press("Enter");
  await page.waitForURL(/docs\/start\/fmu\.html$/);
  await close();
});
