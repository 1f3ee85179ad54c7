// A released FMU comes back with the values of the page: the files that the Python package writes, and what FMPy finds in them.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launch, open } from "./browser.mjs";
import { drop, fitted, LINK as LINK_OF_RIG, RIG } from "./fits.mjs";

const PYTHON = process.env.PYTHON ?? "python3";
const CYLINDER = "PneumaticServoCylinder";
const FMUS = process.env.FMU_FOLDER ?? "../../target/fmu";
const CHANGES = { "friction.law": 14, "mass.moving": 2.5, supplyPressure: 6.5e5, "valve.polarity": -1, "balance.enabled": 1 };
const LINK = Object.entries(CHANGES).map(([name, value]) => `&${CYLINDER}.${name}=${value}`).join("");

/** Compares the files inside two FMUs, and runs both. */
const COMPARE = `
import json, sys, zipfile
import pneumatic_servo as ps
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu
source, page, options = sys.argv[1], sys.argv[2], json.loads(sys.argv[3])
own = str(ps.export_fmu(page + ".python.fmu", source=source, **options)[0])
files = [{it.filename: archive.read(it) for it in archive.infolist()} for archive in map(zipfile.ZipFile, (page, own))]
modes = [{it.filename: it.external_attr for it in zipfile.ZipFile(path).infolist()} for path in (page, own)]
runs = [simulate_fmu(path, stop_time=0.2, start_values={"valveVoltage": 6.5}, output=["position"]) for path in (page, own)]
print(json.dumps({
    "same": files[0] == files[1] and modes[0] == modes[1],
    "bits": runs[0].tobytes() == runs[1].tobytes(),
    "travel": float(abs(runs[0]["position"][-1] - runs[0]["position"][0])),
    "findings": validate_fmu(page),
}))
`;

let browser;
const folder = mkdtempSync(join(tmpdir(), "own-fmu-"));
before(async () => (browser = await launch()));
after(async () => {
  rmSync(folder, { recursive: true });
  await browser.close();
});

const card = (page) => page.locator("#fmu");

/** Hands a file to the page, and takes what it makes. */
const made = (page, file) => saved(page, () => card(page).getByLabel("Released FMU").setInputFiles(file));

/** The file that the page saves after an action. */
async function saved(page, action) {
  const [download] = await Promise.all([page.waitForEvent("download"), action()]);
  const path = join(folder, download.suggestedFilename());
  await download.saveAs(path);
  return path;
}

/** The last line that a program prints, as JSON. */
function python(program, ...arguments_) {
  const answer = spawnSync(PYTHON, ["-c", program, ...arguments_], { encoding: "utf8" });
  assert.equal(answer.status, 0, answer.stderr || String(answer.error));
  return JSON.parse(answer.stdout.trim().split("\n").at(-1));
}

const compared = (source, path, options) => python(COMPARE, source, path, JSON.stringify(options));

for (const [version, preset] of [["", "minimal"], ["fmi3", "rig"]]) {
  test(`the FMU of ${version || "fmi2"} with ${preset} variables is the one that the Python package writes`, async () => {
    const source = join(FMUS, version, `${CYLINDER}.fmu`);
    const { page, close } = await open(browser, `#view=stick-slip${LINK}`);
    await card(page).getByLabel("Name of the machine").fill("Axis 7");
    await card(page).getByLabel("Variables that stay").selectOption(preset);
    const path = await made(page, source);
    assert.match(path, /Axis 7\.fmu$/);
    await close();
    const { same, bits, travel, findings } = compared(source, path, { settings: CHANGES, preset, name: "Axis 7" });
    assert.deepEqual({ same, bits, findings }, { same: true, bits: true, findings: [] });
    assert.ok(travel > 1e-3, `the carriage moves by ${travel} m`);
  });
}

test("a dropped file is taken, and named variables stay", async () => {
  const source = join(FMUS, `${CYLINDER}.fmu`);
  const { page, close } = await open(browser, `#view=stick-slip${LINK}`);
  await card(page).getByText("Name the variables").click();
  await card(page).getByLabel("inputs").fill("valveVoltage, supplyPressure");
  await card(page).getByLabel("outputs").fill("position");
  const path = await saved(page, async () => {
    const base64 = readFileSync(source).toString("base64");
    const files = await page.evaluateHandle((text) => {
      const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
      const carried = new DataTransfer();
      carried.items.add(new File([bytes], "PneumaticServoCylinder.fmu"));
      return carried;
    }, base64);
    await card(page).locator(".drop").dispatchEvent("drop", { dataTransfer: files });
  });
  await close();
  const options = { settings: CHANGES, preset: "minimal", name: "Axis7", inputs: ["valveVoltage", "supplyPressure"], outputs: ["position"] };
  const { same, bits } = compared(source, path, options);
  assert.deepEqual({ same, bits }, { same: true, bits: true });
});

test("what cannot be exported is refused in the words of the library, and nothing is saved", async () => {
  const { page, close } = await open(browser, `#view=stick-slip&${CYLINDER}.motion=2`);
  const problem = card(page).locator(".problem");
  const files = [];
  page.on("download", (file) => files.push(file.suggestedFilename()));
  const refused = async (file, reason, fields = {}) => {
    for (const [label, text] of Object.entries(fields)) await card(page).getByLabel(label).fill(text);
    await card(page).getByLabel("Released FMU").setInputFiles(file);
    await page.waitForFunction((text) => document.querySelector("#fmu .problem").textContent.includes(text), reason);
    assert.equal(await problem.isVisible(), true);
  };
  await card(page).getByText("Name the variables").click();
  const source = join(FMUS, `${CYLINDER}.fmu`);
  await refused(source, "imposedPosition is left out of the inputs", { inputs: "valveVoltage" });
  await refused(source, "there is no variable valveVolts", { inputs: "valveVolts" });
  await refused(source, "the name", { "Name of the machine": "a/b", inputs: "" });
  await refused("package.json", "the FMU cannot be read", { "Name of the machine": "Axis7" });
  assert.deepEqual(files, []);
  await close();
});

test("a fit that is shown is in the FMU, with a section of its documentation page", async () => {
  const { page, close } = await open(browser, `${LINK_OF_RIG}&free=friction.stribeck.Fc`);
  await drop(page, "rig.csv", readFileSync(RIG, "utf8"));
  await page.waitForSelector("table.columns");
  await page.locator("#page details").evaluateAll((all) => all.forEach((details) => details.toggleAttribute("open", true)));
  await page.getByLabel("starts", { exact: true }).fill("0");
  const found = await fitted(page);
  await card(page).getByLabel("Variables that stay").selectOption("all");
  const source = join(FMUS, `${CYLINDER}.fmu`);
  const path = await made(page, source);
  await close();
  const answer = python(
    `
import json, sys, zipfile
from fmpy import read_model_description
from fmpy.validation import validate_fmu
starts = {it.name: it.start for it in read_model_description(sys.argv[1]).modelVariables}
page = zipfile.ZipFile(sys.argv[1]).read("documentation/index.html").decode()
print(json.dumps([float(starts["friction.stribeck.Fc"]), validate_fmu(sys.argv[1]), page]))
`,
    path,
  );
  const [start, findings, text] = answer;
  assert.equal(start, found.get("friction.stribeck.Fc").value);
  assert.deepEqual(findings, []);
  for (const part of ['<a href="#fit">Fit to measured data</a>', "data rig.csv", "friction.stribeck.Fc</th>", "data:image/svg+xml"]) assert.ok(text.includes(part), part);
  const [own, released] = [path, source].map((file) => statSync(file).size);
  assert.ok(own <= 1.01 * released, `${own} bytes, made of ${released}`);
});

test("the drive comes back with the values of plant and controller", async () => {
  const { page, close } = await open(browser, `#view=closed-loop${LINK}&PositionController.gain.position=31`);
  const path = await made(page, join(FMUS, "PneumaticServoDrive.ssp"));
  await close();
  assert.match(path, /Axis7\.ssp$/);
  const settings = Object.fromEntries(Object.entries(CHANGES).map(([name, value]) => [`plant.${name}`, value]));
  const values = JSON.stringify({ ...settings, "controller.gain.position": 31 });
  const isSame = python(
    `
import io, json, sys, zipfile
import pneumatic_servo as ps
source, page, values = sys.argv[1:]
own = ps.export_drive(page + ".python.ssp", json.loads(values), source=source, name="Axis7")
def files(data):
    archive = zipfile.ZipFile(io.BytesIO(data))
    return {it: files(archive.read(it)) if it.endswith(".fmu") else archive.read(it) for it in archive.namelist()}
print(json.dumps(files(open(page, "rb").read()) == files(own.read_bytes())))
`,
    join(FMUS, "PneumaticServoDrive.ssp"),
    path,
    values,
  );
  assert.equal(isSame, true);
});
