// The files for the FMU: what the standard demands of them, and what the Python package reads from them.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { download, launch, open, runFor, VIEWS } from "./browser.mjs";

/** The environment that has the package. */
const PYTHON = process.env.PYTHON ?? "python3";
/** Checks files against the schema of the standard. */
const CHECK = fileURLToPath(new URL("../../packaging/python/check.py", import.meta.url));
const READ = "import json, sys, pneumatic_servo as ps; print(json.dumps(ps.read_ssv(*sys.argv[1:])))";

let browser;
const folder = mkdtempSync(join(tmpdir(), "ssv-"));
before(async () => (browser = await launch()));
after(async () => {
  rmSync(folder, { recursive: true });
  await browser.close();
});

function python(...arguments_) {
  const answer = spawnSync(PYTHON, arguments_, { encoding: "utf8" });
  assert.equal(answer.status, 0, answer.stderr || String(answer.error));
  return answer.stdout;
}

/** A file that the page offers at a query. */
async function file(view, changes = "") {
  const { page, close } = await open(browser, `#view=${view}${changes}`);
  if (view !== "presliding") await runFor(page, 0.05);
  const { name, text } = await download(page, "SSV");
  await close();
  const path = join(folder, name);
  writeFileSync(path, text);
  return { path, text };
}

test("the files are valid", async () => {
  for (const view of VIEWS) {
    const { path, text } = await file(view);
    assert.match(python(CHECK, path), /: 0 findings/);
    const broken = join(folder, "broken.ssv");
    writeFileSync(broken, text.replace("<ssv:Parameters>", "<ssv:Parameters><ssv:Whole/>"));
    assert.notEqual(spawnSync(PYTHON, [CHECK, broken]).status, 0);
  }
});

test("the Python package reads what was set", async () => {
  const of = "PneumaticServoCylinder";
  const changes = { "friction.law": 14, supplyPressure: 600000.5, "valve.polarity": -1, "balance.enabled": 1 };
  const query = Object.entries(changes).map(([name, value]) => `&${of}.${name}=${value}`);
  const { path } = await file("stick-slip", query.join(""));
  const read = JSON.parse(python("-c", READ, path, of));
  const { "friction.law": law, supplyPressure, "valve.polarity": polarity, "balance.enabled": balance } = read;
  assert.deepEqual([law, supplyPressure, polarity, balance], ["LuGre", 600000.5, -1, true]);
});

test("the parts of a system have names of their own", async () => {
  const { text } = await file("closed-loop", "&PositionController.gain.position=30&PneumaticServoCylinder.supplyPressure=550000");
  assert.match(text, /<ssv:Parameter name="controller.gain.position">\s*<ssv:Real value="30.0" unit="[^"]+"\/>/);
  assert.match(text, /<ssv:Parameter name="plant.supplyPressure">\s*<ssv:Real value="550000.0" unit="Pa"\/>/);
});
