// Actions of a visitor, and their effects.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { once } from "node:events";
import { createServer } from "node:http";
import { after, before, test } from "node:test";
import { download, fragment, launch, open, PAGE, runFor, VIEWS } from "./browser.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

const CYLINDER = "PneumaticServoCylinder";
const status = (page) => page.locator("[data-status]").evaluate((element) => ({ ...element.dataset }));
/** Number of coloured pixels of a chart. */
const inked = (page) =>
  page.locator(".plot canvas").evaluateAll((charts) =>
    charts.map((chart) => {
      const { data } = chart.getContext("2d").getImageData(0, 0, chart.width, chart.height);
      return data.reduce((sum, value, index) => sum + (index % 4 === 3 && value > 0), 0);
    }),
  );

for (const view of VIEWS) {
  test(`${view} runs, draws its charts and asks nothing of the network`, async () => {
    const { page, close } = await open(browser, `#view=${view}`);
    if (view !== "presliding") await runFor(page, 0.3);
    await page.waitForTimeout(300);
    const charts = await inked(page);
    assert.ok(charts.length >= 3 && charts.every((count) => count > 1000), String(charts));
    assert.equal(await page.locator("#problem").isVisible(), false);
    await close();
  });

  test(`${view} fits on a screen of 400 pixels, light and dark`, async () => {
    for (const colorScheme of ["light", "dark"]) {
      const { page, close } = await open(browser, `#view=${view}`, {
        viewport: { width: 400, height: 800 },
        colorScheme,
        hasTouch: true,
        isMobile: true,
      });
      await page.waitForTimeout(300);
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 400);
      const [text, back] = await page.evaluate(() => {
        const { color, backgroundColor } = getComputedStyle(document.body);
        return [color, backgroundColor].map((value) => Number(/\d+/.exec(value)[0]));
      });
      assert.equal(text > back, colorScheme === "dark", `text ${text} on ${back}`);
      await close();
    }
  });
}

// Real time is tested by the clock alone (parts.test.mjs): the speed of a browser depends on the machine.
test("all time that passes with the law Stribeck is simulated or counted as dropped", async (context) => {
  const { page, close } = await open(browser, `#view=stick-slip&${CYLINDER}.friction.law=7`);
  const begin = { ...(await status(page)), at: performance.now() };
  await page.waitForTimeout(5000);
  const end = { ...(await status(page)), at: performance.now() };
  const passed = (end.at - begin.at) / 1000;
  const simulated = end.time - begin.time;
  const [frames, dropped] = [end.frames - begin.frames, end.dropped - begin.dropped];
  assert.ok(simulated > 0 && frames > 0);
  // Dropped frames count from the last frame on, and the status is some frames old on a slow machine.
  const lost = passed - simulated - dropped * 1e-3;
  assert.ok(Math.abs(lost) < 1, `${lost} s neither simulated nor counted`);
  const pace = `${frames} frames in 5 s, ${simulated.toFixed(3)} s simulated, ${dropped} steps dropped`;
  context.diagnostic(pace);
  await close();
});

test("pause holds the time, a step takes 1 ms, restart goes back to 0", async () => {
  const { page, close } = await open(browser);
  await runFor(page, 0.1);
  const before = Number((await status(page)).time);
  await page.getByRole("button", { name: "Step 1 ms" }).click();
  await page.waitForTimeout(200);
  assert.equal(Math.round((Number((await status(page)).time) - before) * 1e6), 1000);
  await page.getByRole("button", { name: "Restart" }).click();
  await page.waitForTimeout(200);
  assert.equal(Number((await status(page)).time), 0);
  await close();
});

/** In m; that of the cylinder's default. */
const STROKE = 0.5;
const FIVE_MINUTES = 300;
for (const view of VIEWS.filter((candidate) => candidate !== "presliding")) {
  test(`${view} as it opens keeps the carriage off the end stops for five minutes`, async () => {
    const { page, close } = await open(browser, `#view=${view}`);
    await page.getByRole("button", { name: "60:1" }).click();
    // The file has the last 90 s at least: from the start on the first time, and of a drift all on the second.
    for (const end of [80, FIVE_MINUTES]) {
      await runFor(page, end);
      const [head, ...rows] = (await download(page, "CSV")).text.trimEnd().split("\n").map((line) => line.split(","));
      const places = head.flatMap((name, place) => (name.endsWith("position") && !name.startsWith("controller") ? [place] : []));
      const positions = places.flatMap((place) => rows.map((row) => Number(row[place])));
      const [low, high] = positions.reduce(([least, most], value) => [Math.min(least, value), Math.max(most, value)], [1, 0]);
      assert.ok(rows.length >= 80_000 && low > 0 && high < STROKE, `${low} to ${high} m in ${rows.length} rows`);
      assert.ok(high - low > 0.01, `the carriage moves by ${high - low} m`);
      await page.getByRole("button", { name: "Play" }).click();
    }
    await close();
  });
}

test("everything is reached by the keyboard", async () => {
  const { page, close } = await open(browser);
  await page.keyboard.press("Space");
  assert.equal(await page.getByRole("button", { name: "Play" }).count(), 1);
  const before = Number((await status(page)).time);
  await page.keyboard.press(".");
  await page.waitForTimeout(200);
  assert.ok(Number((await status(page)).time) > before);
  await page.getByRole("tab", { name: "Stick-slip" }).focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  assert.equal(await page.getByRole("tab", { name: "Presliding" }).getAttribute("aria-selected"), "true");
  await page.locator(".sketch").focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Shift+ArrowUp");
  const points = (await fragment(page)).get("points").split(" ").map(Number);
  assert.equal(points[1], 290, "the second point of the nested loops, 20 % higher");
  const widgets = await page.locator("button, select, input, summary, [tabindex='0']").evaluateAll((all) =>
    all.filter((one) => one.tabIndex >= 0 && one.checkVisibility()).length,
  );
  const reached = new Set();
  await page.getByRole("tab", { name: "Presliding" }).focus();
  for (let press = 0; press < widgets + 10; press += 1) {
    reached.add(await page.evaluate(() => [...document.querySelectorAll("*")].indexOf(document.activeElement)));
    await page.keyboard.press("Tab");
  }
  assert.ok(reached.size >= widgets, `${reached.size} of ${widgets}`);
  await close();
});

test("a finger draws the voltage", async () => {
  const { page, close } = await open(browser, "#view=stick-slip", { hasTouch: true });
  await page.getByRole("group", { name: "Valve voltage" }).getByRole("button", { name: "Draw" }).tap();
  const pad = await page.locator(".sketch").boundingBox();
  await page.touchscreen.tap(pad.x + pad.width / 2, pad.y + 1);
  const link = await fragment(page);
  assert.equal(link.get("signal"), "drawn");
  assert.ok(Number(link.get("points").split(" ")[50]) > 950);
  await close();
});

test("a bad value is refused in the words of the library, and the run goes on", async () => {
  const { page, close } = await open(browser);
  await page.getByRole("searchbox").fill("bore");
  const field = page.locator(`[id="${CYLINDER}.cylinder.bore"]`);
  await field.fill("-0.016");
  await field.press("Enter");
  const problem = page.locator(`[id="${CYLINDER}.cylinder.bore-problem"]`);
  assert.equal(await problem.textContent(), "cylinder.bore = -0.016 is refused: it must be at least 0.0001");
  assert.equal(await field.getAttribute("aria-invalid"), "true");
  assert.equal((await fragment(page)).has(`${CYLINDER}.cylinder.bore`), false);
  await field.fill("0.02");
  await field.press("Enter");
  assert.equal(await problem.textContent(), "");
  assert.equal((await fragment(page)).get(`${CYLINDER}.cylinder.bore`), "0.02");
  await field.fill("nonsense");
  await field.press("Enter");
  assert.match(await problem.textContent(), /“nonsense” is no number/);
  await field.fill("20 kg");
  await field.press("Enter");
  assert.match(await problem.textContent(), /kg does not fit, its unit is m, mm,.* or ft/);
  await field.fill("25 mm");
  await field.press("Enter");
  assert.equal((await fragment(page)).get(`${CYLINDER}.cylinder.bore`), "0.025");
  await close();
});

test("every variable that may be set is offered with its text, but not what the page sets itself", async () => {
  const { page, close } = await open(browser, "#view=closed-loop");
  const tables = await page.evaluate(() => globalThis.pneumaticServo.tables);
  const settable = ({ role }) => ["input", "fixed", "tunable"].includes(role);
  const names = tables.models
    .filter((model) => [CYLINDER, "PositionController"].includes(model.name))
    .flatMap((model) => model.variables.filter(settable).map((variable) => `${model.name}.${variable.name}`));
  const shown = await page.locator(".row .field > :first-child").evaluateAll((fields) => fields.map((field) => field.id));
  const driven = names.filter((name) => !shown.includes(name));
  assert.deepEqual(driven.sort(), [
    `${CYLINDER}.valveVoltage`,
    "PositionController.position",
    "PositionController.referencePosition",
    "PositionController.velocity",
  ]);
  await page.getByRole("searchbox").fill("conductance regulator");
  // Of the one regulator, and of one for each chamber.
  assert.deepEqual(await page.locator(".row .name").allTextContents(), ["C", "C"]);
  await close();
});

test("a link restores what was set", async () => {
  const link = `#view=two-laws&signal=ramp&level=4.9&amplitude=1.5&period=2.5&second=16&${CYLINDER}.friction.law=10&${CYLINDER}.valve.C=5e-9`;
  const { page, close } = await open(browser, link);
  assert.equal(await page.getByRole("tab", { name: "Two laws" }).getAttribute("aria-selected"), "true");
  assert.equal(await page.getByLabel("First law", { exact: true }).inputValue(), "10");
  assert.equal(await page.getByLabel("Second law", { exact: true }).inputValue(), "16");
  assert.equal(await page.locator(`[id="${CYLINDER}.valve.C"]`).inputValue(), "5e-9");
  await page.getByRole("button", { name: "Copy link" }).click();
  const now = await fragment(page);
  for (const [name, value] of new URLSearchParams(link.slice(1))) assert.equal(Number(now.get(name)) || now.get(name), Number(value) || value, name);
  await close();
});

test("a link with a value that the library refuses says so", async () => {
  const { page, close } = await open(browser, `#view=stick-slip&${CYLINDER}.cylinder.rod=0.02&nonsense=word`);
  const problem = await page.locator("#problem").textContent();
  assert.match(problem, /cylinder\.rod = 0\.02 is refused/);
  assert.match(problem, /there is no variable nonsense/);
  await close();
});

test("the carriage is pushed by hand, and the files repeat it", async () => {
  const { page, close } = await open(browser, "#view=stick-slip&signal=constant&level=5&amplitude=0&period=1");
  const carriage = await page.locator(".carriage").boundingBox();
  const middle = [carriage.x + carriage.width / 2, carriage.y + carriage.height / 2];
  await page.mouse.move(...middle);
  await page.mouse.down();
  await page.mouse.move(middle[0] + 150, middle[1], { steps: 3 });
  await page.waitForFunction(() => Number.parseFloat(document.querySelector(".newton").textContent) > 11);
  await page.waitForTimeout(600);
  await page.mouse.up();
  await page.waitForFunction(() => document.querySelector(".newton").textContent === "");
  await page.getByRole("slider", { name: "Push the carriage" }).focus();
  await page.keyboard.down("ArrowLeft");
  await page.waitForTimeout(300);
  await page.keyboard.up("ArrowLeft");
  await page.getByRole("button", { name: "Pause" }).click();
  const [head, ...rows] = (await download(page, "CSV")).text.trimEnd().split("\n").map((line) => line.split(","));
  const column = (name) => rows.map((row) => Number(row[head.indexOf(name)]));
  const [force, position] = ["externalForce", "position"].map(column);
  assert.ok(force.some((value) => value > 11) && force.includes(-15) && force.at(-1) === 0);
  assert.ok(Math.max(...position) > position[0] + 1e-3, "more than the static friction moves it");
  assert.match((await download(page, "Python")).text, /"externalForce": \(t, table\["externalForce"\]\)/);
  await close();
});

test("values are typed beside a slider, with a decimal comma too, and a bad one is refused there", async () => {
  const { page, close } = await open(browser);
  const field = page.getByLabel("Amplitude, value");
  await field.fill("0,75 V");
  await field.press("Enter");
  assert.equal((await fragment(page)).get("amplitude"), "0.75");
  await field.fill("abc");
  await field.press("Enter");
  const problem = page.locator(".slider .problem:visible");
  assert.equal(await problem.textContent(), "“abc” is no number");
  assert.equal((await fragment(page)).get("amplitude"), "0.75");
  await field.fill("0.8");
  await field.press("Enter");
  assert.equal(await problem.count(), 0);
  const mass = page.getByLabel("Moving mass, value");
  await mass.fill("500 g");
  await mass.press("Enter");
  assert.match(await problem.textContent(), /“500 g”: .*mass\.moving = 0\.5/);
  await mass.fill("1");
  await mass.press("Enter");
  const supply = page.getByLabel("Supply, value");
  await supply.fill("6,5");
  await supply.press("Enter");
  assert.equal(await supply.inputValue(), "6.5 bar");
  for (const [text, shown] of [["6 barg", "7.01325 bar"], ["87 psi", "5.99844 bar"], ["0.6 MPa", "6 bar"]]) {
    await supply.fill(text);
    await supply.press("Enter");
    assert.equal(await supply.inputValue(), shown, text);
  }
  await supply.fill("600");
  await supply.press("Enter");
  assert.match(await problem.textContent(), /“600” has no unit and would be 600 bar/);
  const load = page.getByLabel("External force, value");
  await load.fill("0.002 kN");
  await load.press("Enter");
  assert.equal(await load.inputValue(), "2 N");
  await supply.fill("700000 Pa");
  await supply.press("Enter");
  assert.equal((await fragment(page)).get(`${CYLINDER}.supplyPressure`), "700000");
  assert.equal(await page.locator(`[id="${CYLINDER}.supplyPressure"]`).inputValue(), "700000", "the list follows the slider");
  await close();
});

test("the sliders that matter are those of the law, and follow the list of parameters", async () => {
  const { page, close } = await open(browser, "#view=stick-slip");
  const names = () => page.locator(".essentials .slider > span").allTextContents();
  assert.equal((await names()).length, 7, "and the period beside the input");
  await page.getByRole("searchbox").fill("Fc");
  await page.locator(`[id="${CYLINDER}.friction.stribeck.Fc"]`).fill("4.5");
  await page.keyboard.press("Enter");
  assert.equal(await page.getByLabel("Coulomb friction, value").inputValue(), "4.5 N");
  await page.getByLabel("Friction law").selectOption("10");
  assert.equal((await names()).includes("Static friction"), false, "the law Dahl has none");
  await close();
});

test("a run is kept behind the next one, a range of time is enlarged, and the pointer tells values", async () => {
  const { page, close } = await open(browser, "#view=stick-slip");
  await runFor(page, 2);
  const grey = () => page.locator(".plot canvas").first().evaluate((chart) => {
    const copy = Object.assign(document.createElement("canvas"), { width: chart.width, height: chart.height }).getContext("2d", { willReadFrequently: true });
    copy.drawImage(chart, 0, 0);
    const { data } = copy.getImageData(0, 0, chart.width, chart.height);
    let count = 0;
    for (let at = 0; at < data.length; at += 4) count += data[at] === 0xb3 && data[at + 1] === 0xbc && data[at + 2] === 0xc5;
    return count;
  });
  assert.equal(await grey(), 0);
  await page.getByRole("button", { name: "Keep" }).click();
  await page.waitForTimeout(200);
  assert.ok((await grey()) > 100, "the kept run is drawn");
  await page.getByRole("button", { name: "Play" }).click();
  await runFor(page, 1);
  await page.locator(".plot").first().scrollIntoViewIfNeeded();
  const chart = await page.locator(".plot .u-over").first().boundingBox();
  const at = (share) => [chart.x + share * chart.width, chart.y + 50];
  await page.mouse.move(...at(0.1));
  assert.match(await page.locator(".values:visible").textContent(), /^0\.[78]\d+ s: [\d.]+ mm$/);
  await page.mouse.down();
  await page.mouse.move(...at(0.05), { steps: 2 });
  await page.mouse.up();
  await page.waitForTimeout(200);
  await page.mouse.move(...at(0.5));
  assert.match(await page.locator(".values:visible").textContent(), /^0\.[56]\d+ s/);
  await page.getByRole("button", { name: "Whole time" }).click();
  await page.getByRole("button", { name: "Let go" }).click();
  await page.waitForTimeout(200);
  assert.equal(await grey(), 0);
  await close();
});

test("the charts are a drawing that scales", async () => {
  const { page, close } = await open(browser, "#view=two-laws");
  await runFor(page, 0.5);
  assert.match(await page.locator(".chart").first().getAttribute("aria-description"), /^From 0 to [\d.]+ s: first law from 250 to [\d.]+ mm, between/);
  const { name, text } = await download(page, "SVG");
  assert.match(name, /^two-laws-.*\.svg$/);
  const found = await page.evaluate((svg) => {
    const drawn = new DOMParser().parseFromString(svg, "image/svg+xml");
    return { failed: drawn.querySelectorAll("parsererror").length, texts: [...drawn.querySelectorAll("text")].map((one) => one.textContent), lines: drawn.querySelectorAll("polyline").length };
  }, text);
  assert.equal(found.failed, 0);
  assert.ok(found.lines >= 7, `${found.lines} lines`);
  for (const label of ["Position in mm", "Time in s", "Velocity in mm/s", "Friction force in N"]) assert.ok(found.texts.includes(label), label);
  await close();
});

/** Message of the page once a race is over. */
async function raceOver(page) {
  const over = () => /wins?\. You: .* PID: /.test(document.querySelector("output.verdict").textContent);
  await page.waitForFunction(over);
  return page.locator("output.verdict").textContent();
}

test("a carriage is raced by hand against the controller, and the link has the score to beat", async () => {
  const { page, close } = await open(browser, "#view=race", { viewport: { width: 400, height: 800 } });
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 400);
  const lever = page.getByRole("slider", { name: "Valve voltage" });
  await lever.fill("6.5");
  await page.waitForTimeout(400);
  await lever.fill("4.8");
  const verdict = await raceOver(page);
  const [, off, time, score] = /You: ([\d.]+) mm off after ([\d.]+) s: score (\d+\.\d+)/.exec(verdict).map(Number);
  assert.ok(Math.abs(off + 0.1 * time - score) < 0.02, verdict);
  assert.equal((await fragment(page)).get("score"), `${off.toFixed(2)} mm ${time.toFixed(2)} s`);
  const link = new URL(page.url()).hash;
  await close();
  const other = await open(browser, link);
  assert.ok((await other.page.locator("output.verdict").textContent()).startsWith(`To beat: ${off.toFixed(2)} mm off`));
  await other.close();
});

test("a program of a link runs when it is told to, touches no network, and is said what is wrong with it", async () => {
  const asked = [];
  const server = createServer((request, answer) => answer.end(String(asked.push(request.url)))).listen(0, "127.0.0.1").unref();
  await once(server, "listening");
  const address = `http://127.0.0.1:${server.address().port}/`;
  const reaching = `try { const ask = new XMLHttpRequest(); ask.open("GET", "${address}", false); ask.send(); } catch {}`;
  const code = `${reaching}\nfunction control(time, position) { return position < 0.29 ? 5.6 : 5; }`;
  const context = await browser.newContext();
  const page = await context.newPage();
  await page.goto(`${PAGE}#${new URLSearchParams({ view: "race", racer: "code", code })}`);
  await page.waitForSelector("html[data-ready]");
  assert.equal(await page.getByLabel("Your program").inputValue(), code);
  assert.equal(await page.getByText("This program came with the link").isVisible(), true);
  await page.keyboard.press("Space");
  await page.waitForTimeout(1000);
  assert.equal(page.workers().length, 0, "nothing runs");
  assert.equal(await page.locator("output.verdict").textContent(), "");
  await page.getByRole("button", { name: "Race", exact: true }).click();
  await raceOver(page);
  assert.deepEqual(asked, []);
  for (const [wrong, problem] of [
    ["function control() { return NaN; }", /control\(0, ...\) returned NaN: it must be a voltage in V/],
    ["let a;\nb = 1;\nfunction control() { return 5; }", /^line 2: .*b is not defined/],
    ["function control() { for (;;); }", /no answer after 10 s/],
  ]) {
    await page.getByLabel("Your program").fill(wrong);
    await page.getByRole("button", { name: "Race", exact: true }).click();
    await page.waitForFunction(() => document.querySelector("output.verdict").textContent !== "The program runs");
    assert.match(await page.locator("output.verdict").textContent(), problem);
  }
  // A worker within a loop ends after some time.
  for (let wait = 0; wait < 50 && page.workers().length > 0; wait += 1) await page.waitForTimeout(200);
  assert.equal(page.workers().length, 0);
  await context.close();
  server.close();
});

test("the search of parameters knows other words and other units", async () => {
  const { page, close } = await open(browser);
  const found = async (words) => {
    await page.getByRole("searchbox").fill(words);
    return page.locator(".row .field > :first-child").evaluateAll((fields) => fields.map((field) => field.id.split(".").slice(1).join(".")));
  };
  assert.ok((await found("stiction")).includes("friction.stribeck.Fs"));
  assert.ok((await found("bar")).includes("supplyPressure"));
  assert.ok((await found("solenoid")).some((name) => name.startsWith("switching.")));
  await close();
});

test("Back goes to the view before, and a story opens its setting", async () => {
  const { page, close } = await open(browser);
  const isChosen = (name) => page.waitForFunction((wanted) => document.querySelector("[aria-selected=true]").textContent === wanted, name);
  await page.getByRole("tab", { name: "Closed loop" }).click();
  await page.getByLabel("Amplitude, value").fill("30");
  await page.keyboard.press("Enter");
  await page.getByRole("tab", { name: "Two laws" }).click();
  await page.goBack();
  await isChosen("Closed loop");
  assert.equal(await page.getByLabel("Amplitude, value").inputValue(), "30 mm");
  await page.goBack();
  await isChosen("Stick-slip");
  for (const story of await page.locator(".stories a").all()) {
    await story.click();
    await page.waitForTimeout(200);
    assert.equal(await page.locator("#problem").isVisible(), false, await story.textContent());
  }
  await isChosen("Fit");
  await close();
});

test("loops of springs and sliders close, those of a single bristle do not", async () => {
  const verdict = async (link) => {
    const { page, close } = await open(browser, `#view=presliding&${link}`);
    await page.waitForSelector(".verdict li");
    const text = await page.locator(".verdict strong").textContent();
    await close();
    return text;
  };
  assert.equal(await verdict("FrictionBench.friction.law=17"), "3 of 3 loops close");
  const bristle = "FrictionBench.friction.law=14";
  assert.match(await verdict(bristle), /^[0-2] of 3 loops close$/);
});

test("gains are tuned while the loop runs", async () => {
  const { page, close } = await open(browser, "#view=closed-loop");
  await runFor(page, 0.1);
  const time = (await status(page)).time;
  await page.getByLabel("Position gain", { exact: true }).fill("30");
  await page.waitForTimeout(200);
  assert.equal((await status(page)).time, time, "the run does not restart");
  assert.equal((await fragment(page)).get("PositionController.gain.position"), "30");
  const { text } = await download(page, "Python");
  assert.match(text, /controller_changes = \{\n    \d+: \{\n        "gain.position": 30,/);
  await close();
});

test("the files repeat the setting for the FMU and for Python", async () => {
  const { page, close } = await open(browser, `#view=stick-slip&${CYLINDER}.friction.law=14&${CYLINDER}.supplyPressure=600000`);
  await runFor(page, 0.05);
  const { name, text } = await download(page, "SSV");
  assert.match(name, /^stick-slip-.*\.ssv$/);
  assert.match(text, /<ssv:Parameter name="friction.law">\s*<ssv:Enumeration value="LuGre"\/>/);
  assert.match(text, /<ssv:Real value="600000.0" unit="Pa"\/>/);
  assert.match(text, /<ssc:BaseUnit kg="1" m="-1" s="-2"\/>/);
  const parts = [`plant = ps.Model("${CYLINDER}")`, '"friction.law": "LuGre"', '"supplyPressure": 600000'];
  const python = await download(page, "Python");
  for (const part of parts) assert.ok(python.text.includes(part), python.text);
  await close();
  for (const view of VIEWS) {
    const { page, close } = await open(browser, `#view=${view}`);
    if (view !== "presliding") await runFor(page, 0.05);
    const { text } = await download(page, "Python");
    const parsed = spawnSync("python3", ["-c", "import ast, sys; ast.parse(sys.stdin.read())"], { input: text });
    assert.equal(parsed.status, 0, `${parsed.stderr}\n${text}`);
    await close();
  }
});

test("light and dark are chosen by a button", async () => {
  const { page, close } = await open(browser, "", { colorScheme: "light" });
  const back = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await back();
  await page.locator("#theme").click();
  assert.notEqual(await back(), light);
  assert.equal(await page.locator("#theme").textContent(), "Light");
  const dark = await back();
  await page.reload();
  await page.waitForSelector("html[data-ready]");
  assert.equal(await back(), dark, "the choice outlasts a reload");
  await close();
});

test("a language that the browser cannot write numbers in does not leave the page empty", async () => {
  // WebKit names the locale C.UTF-8 so.
  const { page, close } = await open(browser, "", { language: "C" });
  await runFor(page, 0.1);
  assert.ok((await inked(page)).every((count) => count > 1000));
  await close();
});

/** Languages that write numbers in other ways: with a decimal comma, other digits, other separators. */
for (const locale of ["de-DE", "fr-CH", "ar-EG", "hi-IN"]) {
  test(`numbers are read and written alike in the language ${locale}`, async () => {
    const { page, close } = await open(browser, `#view=closed-loop&${CYLINDER}.supplyPressure=650000`, { locale });
    assert.equal(await page.evaluate(() => navigator.language), locale);
    await runFor(page, 0.2);
    assert.equal(await page.getByLabel("Supply, value").inputValue(), "6.5 bar");
    const field = page.getByLabel("Amplitude, value");
    for (const text of ["12,5 mm", "12.5"]) {
      await field.fill("30");
      await field.press("Enter");
      await field.fill(text);
      await field.press("Enter");
      assert.equal((await fragment(page)).get("amplitude"), "0.0125", text);
    }
    assert.match(await page.locator(".readouts").textContent(), /Position\d+\.\d\d mm/);
    const { text } = await download(page, "CSV");
    const [head, row] = text.split("\n").map((line) => line.split(","));
    assert.ok(row.length === head.length && row.every((cell) => Number.isFinite(Number(cell))), row.join(" "));
    assert.match((await download(page, "Python")).text, /"supplyPressure": 650000/);
    assert.ok((await inked(page)).every((count) => count > 1000));
    await close();
  });
}

test("in the frame of another page only the plant shows, in its colours", async () => {
  const { page, close } = await open(browser, "?embed&theme=dark", { colorScheme: "light", viewport: { width: 400, height: 800 } });
  await runFor(page, 0.1);
  const isShown = (selector) => page.locator(selector).first().isVisible();
  for (const hidden of ["header", ".strip", "aside", "footer", ".others .chart"]) assert.equal(await isShown(hidden), false, hidden);
  for (const shown of [".cylinder", ".transport", ".signal-editor", ".chart"]) assert.equal(await isShown(shown), true, shown);
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 400);
  const back = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const dark = await back();
  await page.evaluate(() => postMessage({ theme: "light" }, "*"));
  await page.waitForFunction((before) => getComputedStyle(document.body).backgroundColor !== before, dark);
  await page.evaluate(() => postMessage({ theme: "nonsense" }, "*"));
  await page.waitForTimeout(100);
  assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "light");
  await close();
});

test("a visitor who wants less motion starts the embedded plant himself", async () => {
  const { page, close } = await open(browser, "?embedded", { reducedMotion: "reduce" });
  await page.waitForTimeout(300);
  assert.equal(Number((await status(page)).time), 0);
  await page.getByRole("button", { name: "Play" }).click();
  await runFor(page, 0.1);
  await close();
});
