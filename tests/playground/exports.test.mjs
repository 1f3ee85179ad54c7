// The files of a run belong together, without a browser and without the plant.
import assert from "node:assert/strict";
import { test } from "node:test";
import { part } from "./part.mjs";

const NOTHING = { ssv: "", charts: [] };
const TABLES = {
  models: [{ name: "Plant", variables: ["valveVoltage", "position", "mass"].map((name) => ({ name, kind: "Real" })) }],
};

/** A library whose plant holds values and counts its steps as its position. */
function library() {
  const start = (_, __, values) => {
    const shown = new Map([["position", 0], ...values]);
    return {
      advance: () => shown.set("position", shown.get("position") + 1),
      set: (given) => given.forEach((value, name) => shown.set(name, value)),
      reader: (names) => () => Float64Array.from(names, (name) => shown.get(name)),
    };
  };
  return { start };
}

/** A run of one plant, whose start values are `values`. */
async function started(values) {
  const { Run } = await part("run");
  const member = { prefix: "", model: "Plant", values, first: new Map([["valveVoltage", 5]]), watched: ["valveVoltage", "position"] };
  return new Run(library(), [member], (time, run) => run.set(0, new Map([["valveVoltage", 5 + time]])));
}

test("a program reads the file of its own run and instant, and of no other", async () => {
  const { filesOfRun } = await part("exports");
  const run = await started(new Map());
  const files = () => filesOfRun("view", run.recording, (csv) => `reads ${csv}`, NOTHING);
  const first = files();
  assert.equal(first.python, `reads ${first.name}.csv`);
  assert.deepEqual([files().name, files().csv], [first.name, first.csv], "nothing has changed");
  run.step();
  const second = files();
  assert.notEqual(second.name, first.name);
  assert.equal(first.python, `reads ${first.name}.csv`);
  const other = await started(new Map([["position", 1]]));
  other.step();
  assert.equal(other.recording.rows, run.recording.rows);
  assert.notEqual(filesOfRun("view", other.recording, String, NOTHING).name, second.name, "another run of the same length");
});

test("of a run whose beginning is gone there is a file, and no program but a remedy", async () => {
  const { filesOfRun } = await part("exports");
  const run = await started(new Map());
  while (!run.recording.isCut) run.step();
  const files = filesOfRun("view", run.recording, String, NOTHING);
  assert.match(files.csv.split("\n")[1], /^30,/);
  assert.throws(() => files.python, /last 120 s .* from 30 s on\. Restart, and export within 120 s/);
});

test("a program begins with the values of the start, and changes them in the row in which they were changed", async () => {
  const { oneModel } = await part("python");
  const settings = new Map([["mass", 2]]);
  const run = await started(settings);
  const program = () => oneModel(TABLES, run, ["run"], "valveVoltage", null, "run.csv");
  assert.match(program(), /plant\.simulate\(\{\n    "mass": 2,\n\}/);
  for (let row = 0; row < 7; row += 1) run.step();
  for (const mass of [3, 0.1]) {
    settings.set("mass", mass);
    run.retune("Plant", "mass", mass);
  }
  run.retune("Other", "mass", 9);
  const text = program();
  assert.match(text, /run = stepped\(\{\n    "mass": 2,\n\}/, text);
  assert.match(text, /changes = \{\n    7: \{\n        "mass": 0\.1,\n    \},\n\}/, text);
});
