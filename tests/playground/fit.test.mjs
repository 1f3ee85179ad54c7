// Fits as a visitor makes them: a table is dropped, columns are assigned, values and intervals come out.
import assert from "node:assert/strict";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { download, fragment, launch, open } from "./browser.mjs";
import { button, CYLINDER, drop, fitted, FREE, LINK, option, RIG } from "./fits.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

test("the rig is dropped and fitted: what the rig has is within the intervals, and the FMU gets the values", async () => {
  const { page, close } = await open(browser, LINK);
  await drop(page, "rig.csv", await readFile(RIG, "utf8"));
  await page.waitForSelector("table.columns");
  assert.equal(await page.getByLabel("Column of position").inputValue(), "2");
  assert.equal(await page.getByLabel("Unit of position").inputValue(), "mm");
  const found = await fitted(page);
  assert.equal(await page.locator("[data-result]").getAttribute("data-result"), "converged");
  assert.deepEqual([...found.keys()], FREE);
  for (const [name, { value, low, high }] of found) {
    assert.ok(low < value && value < high && (high - low) / value < 0.1, `${name} = ${value} [${low}, ${high}]`);
  }
  // No more than the noise of the sensors: 10 um and a converter of 0.122 mm, 500 Pa and one of 147 Pa.
  const left = await page.locator("tr[data-signal]").evaluateAll((all) => all.map(({ dataset }) => Number(dataset.rms)));
  assert.ok(left.length === 3 && left[0] < 6e-5 && left[1] < 600 && left[2] < 600, String(left));
  assert.equal(await page.locator(".fit .chart").count(), 6);

  const ssv = await download(page, "SSV");
  assert.equal(ssv.name, "rig-fitted.ssv");
  const written = (name) => Number(new RegExp(`"${name.replaceAll(".", "\\.")}">\\s*<ssv:Real value="([^"]+)"`).exec(ssv.text)?.[1]);
  for (const [name, { value }] of found) assert.equal(written(name), value, name);
  assert.equal(written("supplyPressure"), 6e5);
  assert.match(ssv.text, /"friction.law">\s*<ssv:Enumeration value="Stribeck"/);
  const csv = await download(page, "CSV");
  const [head, ...rows] = csv.text.trimEnd().split("\n").map((line) => line.split(","));
  assert.deepEqual(head.slice(0, 3), ["time", "measured.position", "simulated.position"]);
  assert.equal(rows.length, 3001);
  assert.ok(rows.every(([, measured, simulated]) => Math.abs(measured - simulated) < 5e-4));

  await page.getByRole("button", { name: "Use in the other pages" }).click();
  await page.getByRole("tab", { name: "Stick-slip" }).click();
  const field = page.locator(`[id="${CYLINDER}.friction.stribeck.Fs"]`);
  assert.equal(Number(await field.inputValue()), found.get("friction.stribeck.Fs").value);
  // The table and the fit are still there.
  await page.getByRole("tab", { name: "Fit", exact: true }).click();
  assert.equal(await page.locator("tr[data-name]").count(), FREE.length);
  await close();
});

test("the example is one button away", async () => {
  const { page, close } = await open(browser, "#view=fit");
  await page.getByRole("button", { name: "Try the example" }).click();
  await page.waitForSelector("table.columns");
  assert.equal(await page.locator(`[id="${CYLINDER}.supplyPressure"]`).inputValue(), "600000");
  const names = await page.locator(".free").evaluateAll((all) => all.filter((one) => one.firstChild.checked).map((one) => one.textContent));
  assert.deepEqual(names, FREE);
  await close();
});

test("a supply that was given above ambient is named as the cause, a report is printed on one page, and a button follows the cause", async () => {
  const rows = (await readFile(RIG, "utf8")).trimEnd().split("\n").slice(1);
  const text = ["Zeit [s],Valve voltage (V),Stroke (mm),Pressure A (bar),Pressure B (bar)", ...rows].join("\n");
  const { page, close } = await open(browser, LINK.replace("supplyPressure=600000", "supplyPressure=498675"));
  await drop(page, "measured.csv", text);
  await page.waitForSelector("table.columns");
  for (const [signal, place, unit] of [["time", "0", "s"], ["valveVoltage", "1", "V"], ["position", "2", "mm"], ["chamberA.pressure", "3", "bar"]]) {
    assert.equal(await page.getByLabel(`Column of ${signal}`).inputValue(), place);
    assert.equal(await page.getByLabel(`Unit of ${signal}`).inputValue(), unit);
    assert.ok(await page.getByLabel(`Unit of ${signal}`).isEnabled());
  }
  await fitted(page);
  assert.notEqual(await page.locator("[data-result]").getAttribute("data-light"), "green");
  const cause = await page.locator("[data-result] [data-cause]").textContent();
  assert.match(cause, /would be gone if supplyPressure, fixed at 498675 Pa, were (59|60)\d+(\.\d+)? \[.*above ambient/);
  const ssv = await download(page, "SSV");
  for (const name of ["position0", "velocity0", "chamberA.pressure0"]) assert.ok(ssv.text.includes(`"${name}"`), name);
  // A browser without a window prints by a command of its own.
  await page.evaluate(() => (window.print = () => {}));
  await page.getByRole("button", { name: "Print a report" }).click();
  const pdf = (await page.pdf({ preferCSSPageSize: true })).toString("latin1");
  assert.equal(pdf.match(/\/Type\s*\/Page\b/g)?.length, 1);
  // The button that follows the cause fits again with it: no pressure explains more.
  await page.getByRole("button", { name: /^Set supplyPressure to (5\.9[0-9]*|6[.0-9]*) bar and fit again$/ }).click();
  await page.waitForFunction(() => document.querySelector("[data-result]") && !document.querySelector("[data-cause]"));
  assert.equal(await page.locator("[data-result]").getAttribute("data-light"), "green");
  await close();
});

test("what is known of the machine is asked for, and a supply may count from the atmosphere", async () => {
  const { page, close } = await open(browser, LINK);
  const known = page.getByRole("group", { name: "Known of the machine" });
  assert.equal(await known.getByLabel("valve.C", { exact: true }).count(), 0, "what is free is not known");
  await known.getByLabel("Unit of supplyPressure").selectOption("barg");
  await known.getByLabel("supplyPressure", { exact: true }).fill("5");
  await known.getByLabel("supplyPressure", { exact: true }).press("Enter");
  assert.equal(await page.locator(`[id="${CYLINDER}.supplyPressure"]`).inputValue(), "601325");
  await known.getByLabel("cylinder.bore", { exact: true }).fill("-16");
  await known.getByLabel("cylinder.bore", { exact: true }).press("Enter");
  assert.match(await known.getByRole("alert").textContent(), /cylinder\.bore = -0\.016/);
  await close();
});

test("a bench is fitted: the friction that its force was made with comes out", async () => {
  const noise = (row) => 0.02 * Math.sin(row * row);
  const rows = Array.from({ length: 2001 }, (_, row) => {
    const speed = 0.05 * Math.cos(row * 5e-3);
    const force = Math.sign(speed) * 7 + 30 * speed + noise(row);
    return `${row * 1e-3};${String(10 * Math.sin(row * 5e-3)).replace(".", ",")};${String(force).replace(".", ",")}`.replace(/^(\d+)\.(\d+)/, "$1,$2");
  });
  const { page, close } = await open(browser, "#view=fit&experiment=motion&FrictionBench.friction.law=2");
  await drop(page, "bench.csv", `t;x[mm];Ff\n${rows.join("\n")}\n`);
  await page.waitForSelector("table.columns");
  assert.equal(await page.getByLabel("Unit of position").inputValue(), "mm", "the unit that the table writes is chosen");
  assert.equal(await page.getByLabel("Unit of position").isDisabled(), false, "and may be wrong");
  const law = await page.getByLabel("Law", { exact: true }).evaluate((select) => select.selectedOptions[0].textContent);
  assert.match(law, /^Coulomb:/);
  await page.getByText("Options of the fit").click();
  await option(page, "play").fill("0 mm");
  await option(page, "play").press("Enter");
  const found = await fitted(page);
  const { value, low, high } = found.get("friction.coulomb.Fc");
  // The disturbance is no noise: it may move the value by a share of its size.
  assert.ok(Math.abs(value - 7) < 0.01 && low < high, `Fc = ${value} [${low}, ${high}]`);
  assert.ok(Math.abs(found.get("friction.coulomb.sigma2").value - 30) < 0.3, String(found.get("friction.coulomb.sigma2").value));
  await close();
});

test("each experiment offers its signals, what may be known of its bench, and the options that act", async () => {
  const { page, close } = await open(browser, "#view=fit", { viewport: { width: 390, height: 844 } });
  const experiments = await page.evaluate(() => globalThis.pneumaticServo.tables.experiments);
  await drop(page, "axis.csv", `t,x [mm],F [N]\n${Array.from({ length: 100 }, (_, row) => `${row / 1e3},${row % 7},${row % 5}`).join("\n")}\n`);
  await page.waitForSelector("table.columns");
  await page.getByText("Options of the fit").click();
  for (const { name, signals, options } of experiments) {
    await page.getByRole("group", { name: "Experiment", exact: true }).getByRole("button", { name, exact: true }).click();
    const labels = (prefix) => page.locator(`[aria-label^="${prefix}"]`).evaluateAll((all) => all.map((one) => one.getAttribute("aria-label")));
    assert.deepEqual(await labels("Column of "), signals.map((signal) => `Column of ${signal}`));
    await page.getByText("Options of the fit").click();
    for (const known of ["width", "smoothing", "rated", "play", "segment", "inputs"]) {
      assert.equal(await option(page, known).count(), options.some((one) => one.name === known) ? 1 : 0, `${name}: ${known}`);
    }
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 390, name);
  }
  await page.getByRole("button", { name: "force", exact: true }).click();
  const known = page.getByRole("group", { name: "Known of the machine" });
  await page.locator("label.free", { hasText: /^mass$/ }).locator("input").uncheck();
  assert.equal(await known.getByLabel("mass", { exact: true }).inputValue(), "", "the mass of an axis has no default");
  assert.equal(await known.getByLabel("incline", { exact: true }).count(), 1);
  await close();
});

test("options are automatic until they are given, and a bad one is refused by its name", async () => {
  const { page, close } = await open(browser, "#view=fit&experiment=force");
  await page.getByText("Options of the fit").click();
  const give = async (name, text) => {
    await option(page, name).fill(text);
    await option(page, name).press("Enter");
    return page.locator(".options [role=alert]").textContent();
  };
  assert.deepEqual(
    [await option(page, "segment").inputValue(), await option(page, "inputs").inputValue()],
    ["", ""],
  );
  for (const [name, text, problem] of [
    ["segment", "0", "segment = 0 is refused: it must be positive"],
    ["segment", "long", "segment: “long” is no number"],
    ["width", "3 bar", /^width: “3 bar”: bar does not fit, its unit is ms, s,/],
    ["validation", "100", "validation = 100 is refused: it must be below 100 %"],
    ["starts", "1.5", "starts = 1.5 is refused: it must be whole"],
  ]) {
    const told = await give(name, text);
    if (typeof problem === "string") assert.equal(told, problem);
    else assert.match(told, problem);
    assert.equal(await option(page, name).getAttribute("aria-invalid"), "true");
  }
  for (const [name, text] of [["segment", "300 ms"], ["width", ""], ["validation", "20"], ["starts", "8"]]) assert.equal(await give(name, text), "");
  await option(page, "inputs").selectOption("hold");
  await option(page, "smoothing").selectOption("off");
  const link = await fragment(page);
  const given = Object.fromEntries(["segment", "width", "validation", "starts", "inputs", "smoothing"].map((name) => [name, link.get(name)]));
  assert.deepEqual(given, { segment: "0.3", width: null, validation: "0.2", starts: null, inputs: "hold", smoothing: "off" });
  await close();
});

test("a link restores fixed values, corrected sensors, rows that are left out, and options", async () => {
  const settings = {
    segment: "0.3",
    inputs: "lines",
    smoothing: "on",
    "known.mass": "20",
    "known.incline": "0.1",
    "known.offset.force": "3",
    "known.delay.position": "0.002",
    leftOut: "5 7-9",
  };
  const link = `#view=fit&experiment=force&free=friction.coulomb.Fc&${new URLSearchParams(settings)}&FrictionBench.friction.law=2`;
  const { page, close } = await open(browser, link);
  const rows = Array.from({ length: 200 }, (_, row) => `${row / 1e3},${(10 * Math.sin(row / 20)).toFixed(4)},${(5 * Math.cos(row / 20)).toFixed(4)}`);
  await drop(page, "axis.csv", `t,x [mm],F [N]\n${rows.join("\n")}\n`);
  await page.getByText("axis.csv: 196 rows").waitFor();
  assert.match(await page.locator(".sensors").textContent(), /offset\.force = 3 N, delay\.position = 0\.002 s, 4 rows left out/);
  const known = page.getByRole("group", { name: "Known of the machine" });
  assert.deepEqual([await known.getByLabel("mass", { exact: true }).inputValue(), await known.getByLabel("incline", { exact: true }).inputValue()], ["20", "0.1"]);
  await page.getByText("Options of the fit").click();
  assert.equal(await option(page, "segment").inputValue(), "0.3");
  assert.equal(await option(page, "inputs").inputValue(), "lines");
  const same = await fragment(page);
  for (const [name, value] of Object.entries(settings)) assert.equal(same.get(name), value, name);
  // They are of this table: another one is taken as it is.
  await drop(page, "other.csv", `t,x [mm],F [N]\n${rows.join("\n")}\n`);
  await page.getByText("other.csv: 200 rows").waitFor();
  const other = await fragment(page);
  assert.deepEqual([other.get("leftOut"), other.get("known.offset.force"), other.get("known.mass"), other.get("segment")], [null, null, "20", "0.3"]);
  await close();
});

test("what a link of a fit cannot mean is named", async () => {
  const { page, close } = await open(browser, "#view=fit&experiment=motion&segment=-1&inputs=smooth&known.area=wide&leftOut=all");
  const told = await page.locator("#problem").textContent();
  for (const problem of ["segment = -1 is refused: it must be positive", "there is no variable inputs", "known.area = wide is no number", "leftOut = all are no lines of a table"]) {
    assert.ok(told.includes(problem), `${problem}: ${told}`);
  }
  await close();
});

test("a machine that rotates is told by its columns: its mass is an inertia, and a mixture is refused", async () => {
  const { page, close } = await open(browser, "#view=fit&experiment=force&FrictionBench.friction.law=2&free=friction.coulomb.Fc");
  const rows = Array.from({ length: 200 }, (_, row) => `${row / 1e3},${(10 * Math.sin(row / 20)).toFixed(4)},${(5 * Math.cos(row / 20)).toFixed(4)},1`);
  await drop(page, "rotor.csv", `t,x [deg],F [mA],v\n${rows.join("\n")}\n`);
  await page.waitForSelector("table.columns");
  await page.getByLabel("Column of velocity").selectOption("-1");
  const known = page.getByRole("group", { name: "Known of the machine" });
  assert.equal(await known.getByLabel("Unit of mass").inputValue(), "kg.m2");
  assert.equal(await known.getByLabel("Unit of gain.force").inputValue(), "N.m/A");
  assert.equal(await known.getByLabel("incline", { exact: true }).count(), 0, "a rotating machine has none");
  await known.getByLabel("mass", { exact: true }).fill("200 kg.cm2");
  await known.getByLabel("mass", { exact: true }).press("Enter");
  assert.equal(await known.getByLabel("mass", { exact: true }).inputValue(), "0.02");
  await known.getByLabel("mass", { exact: true }).fill("2 kg");
  await known.getByLabel("mass", { exact: true }).press("Enter");
  assert.match(await known.getByRole("alert").textContent(), /^mass: “2 kg”: kg does not fit, its unit is kg\.m2/);
  await page.getByLabel("Column of velocity").selectOption("3");
  await page.getByText("velocity is in m/s, but position in rad: a machine slides or it rotates; which is it?").waitFor();
  assert.equal(await button(page).isDisabled(), true);
  await page.getByLabel("Unit of velocity").selectOption("rpm");
  await page.getByText("a machine slides or it rotates").waitFor({ state: "detached" });
  await close();
});

test("readings in volts are taken by two points, and what is wrong with these is said beside them", async () => {
  const { page, close } = await open(browser, LINK);
  const [, ...rows] = (await readFile(RIG, "utf8")).trimEnd().split("\n").map((row) => row.split(","));
  await drop(page, "rig.csv", ["t,u,x [V]", ...rows.map(([t, u, x]) => `${t},${u},${x / 50}`)].join("\n"));
  await page.waitForSelector("table.columns");
  await page.getByLabel("Unit of position").selectOption("two points");
  const field = page.getByLabel("Calibration of position");
  const first = () => page.locator("table.columns tr", { has: page.getByRole("rowheader", { name: "position", exact: true }) }).locator("td").last().textContent();
  for (const [text, problem] of [["0..10 V", /is written as/], ["0..10 V = 0..500 bar", /unit bar is refused/]]) {
    await field.fill(text);
    await field.press("Enter");
    await page.locator("table.columns .problem", { hasText: problem }).waitFor();
    assert.equal(await first(), "");
  }
  await field.fill("0..10 V = 0..500 mm");
  await field.press("Enter");
  await page.getByText("0.25006 m").waitFor();
  assert.equal(await page.locator("table.columns .problem").textContent(), "");
  // The table says volts.
  await field.fill("4..20 mA = 0..500 mm");
  await field.press("Enter");
  await button(page).click();
  assert.match(await page.locator("[data-problem]").textContent(), /column 3 \(x\): the table says V, but the calibration .* reads mA/);
  await close();
});

test("tables that cannot be read are named by line and column, and what is missing is said", async () => {
  const { page, close } = await open(browser, LINK);
  const problem = async (name, text) => {
    await drop(page, name, text);
    await page.waitForFunction((begin) => document.querySelector("[data-problem]")?.textContent.startsWith(begin), name);
    return page.locator("[data-problem]").textContent();
  };
  assert.equal(await problem("one.csv", "t,u,x\n0,1,2\n0.1,1,two\n"), "one.csv:3, column 3 (x): 'two' is no number");
  assert.equal(await problem("two.csv", "t,u,x\n0,1,2\n0.1,1\n"), "two.csv:3: 2 values, but the header has 3 columns");
  assert.equal(await button(page).isDisabled(), true);
  await drop(page, "three.csv", "t,x\n0,1\n1,2\n");
  await page.waitForSelector("table.columns");
  await page.getByText("valveVoltage is missing").waitFor();
  await drop(page, "four.csv", "t,u,x\n0,1,2\n1,1,3\n1,2,3\n");
  await page.getByText("four.csv: 3 rows").waitFor();
  await button(page).click();
  assert.equal(await page.locator("[data-problem]").textContent(), "four.csv:4, column t: time must rise, but 1 s follows 1 s");
  await close();
});

test("what cannot be simulated is told in the words of the library", async () => {
  const { page, close } = await open(browser, LINK);
  const [head, ...rows] = (await readFile(RIG, "utf8")).trimEnd().split("\n");
  // Behind the end of the stroke by no more than a sensor may be wrong.
  const beyond = rows.map((row) => {
    const [t, u, x, ...pressures] = row.split(",");
    return [t, u, 503 - Math.abs(x - 250.061), ...pressures].join(",");
  });
  await drop(page, "rig.csv", [head, ...beyond].join("\n"));
  await page.waitForSelector("table.columns");
  await button(page).click();
  await page.waitForSelector("[data-problem]");
  const problem = await page.locator("[data-problem]").textContent();
  assert.match(problem, /^the start values cannot be simulated: position0 = 0\.50\d+ is refused/);
  await close();
});

/** The longest time in ms in which the page drew nothing, until the next call. */
const watchFrames = (page) =>
  page.evaluate(() => {
    globalThis.longest = 0;
    let last = performance.now();
    const frame = (now) => {
      globalThis.longest = Math.max(globalThis.longest, now - last);
      last = now;
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  });

test("a million rows are read and fitted beside a page that goes on, and the fit can be cancelled", async (context) => {
  const folder = await mkdtemp(join(tmpdir(), "playground-"));
  const file = join(folder, "long.csv");
  const rows = Array.from({ length: 1_000_000 }, (_, row) => {
    const time = row * 1e-3;
    return `${time.toFixed(3)},${(5 + Math.sin(time)).toFixed(4)},${(250 + 5 * Math.sin(time)).toFixed(3)}`;
  });
  await writeFile(file, `t,u,x[mm]\n${rows.join("\n")}\n`);
  const { page, close } = await open(browser, LINK);
  await watchFrames(page);
  await page.getByLabel("Open a table").setInputFiles(file);
  await page.getByText("1000000 rows").waitFor();
  await button(page).click();
  await page.waitForFunction(() => /run [1-9]/.test(document.querySelector("[data-progress]")?.textContent ?? ""));
  const shares = new Set();
  for (let look = 0; look < 5; look += 1) {
    shares.add(await page.locator("progress").evaluate((bar) => bar.value));
    await page.waitForTimeout(300);
  }
  assert.ok(shares.size > 1, `the bar moves: ${[...shares]}`);
  await page.getByRole("tab", { name: "Presliding" }).click();
  await page.getByRole("tab", { name: "Fit", exact: true }).click();
  await button(page).click();
  await page.getByText("cancelled").waitFor();
  assert.equal(await button(page).textContent(), "Fit");
  const longest = await page.evaluate(() => globalThis.longest);
  context.diagnostic(`the page drew nothing for ${longest.toFixed(0)} ms at most`);
  // On a loaded machine of two cores other programs take their part; in the page itself the fit would take minutes.
  assert.ok(longest < 3000, `${longest} ms without a frame`);
  await rm(folder, { recursive: true });
  await close();
});

test("a file that is dropped beside its place does not replace the page", async () => {
  const { page, close } = await open(browser, "#view=fit");
  const isPrevented = await page.evaluate(() => {
    const event = new DragEvent("drop", { bubbles: true, cancelable: true });
    document.body.dispatchEvent(event);
    return event.defaultPrevented;
  });
  assert.equal(isPrevented, true);
  await close();
});

test("the fit is reached by keys, and fits on a screen of 400 pixels in light and dark", async () => {
  for (const colorScheme of ["light", "dark"]) {
    const { page, close } = await open(browser, LINK, { viewport: { width: 400, height: 800 }, colorScheme, hasTouch: true, isMobile: true });
    await page.getByRole("button", { name: "Try the example" }).focus();
    await page.keyboard.press("Enter");
    await page.waitForSelector("table.columns");
    await button(page).focus();
    await page.keyboard.press("Enter");
    await page.waitForSelector("[data-result]");
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 400);
    await close();
  }
});
