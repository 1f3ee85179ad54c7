// The page computes what the library computes, to the last bit.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { download, launch, open, runFor } from "./browser.mjs";
import { bits, replay } from "./native.mjs";

const CYLINDER = "PneumaticServoCylinder";
let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

const ROWS = 300;
const STEP = 1e-3;

/** From 0 to 1 to -1 and to 0 again within 100 rows, in numbers that every machine has exactly. */
const triangle = (row) => {
  const phase = (row % 100) / 100;
  return phase < 0.25 ? 4 * phase : phase < 0.75 ? 2 - 4 * phase : 4 * phase - 4;
};

/** Every model, under every law if it has friction, with all of its inputs in motion. */
function experiments(tables) {
  return tables.models.flatMap((model) => {
    const inputs = model.variables.filter((variable) => variable.role === "input" && variable.kind === "Real");
    const outputs = model.variables.filter((variable) => variable.role === "output").map((variable) => variable.name);
    const rows = Array.from({ length: ROWS }, (_, row) => [
      row * STEP,
      ...inputs.map(({ start }, index) => start + (Math.abs(start) || 1) * 0.1 * triangle(row + 7 * index)),
    ]);
    const law = model.variables.find((variable) => variable.of === "FrictionLaw");
    const choices = law ? tables.enumerations.FrictionLaw.items.map((item) => ({ [law.name]: item.id })) : [{}];
    const names = inputs.map((variable) => variable.name);
    return choices.map((values) => ({ model: model.name, values, inputs: names, outputs, rows }));
  });
}

/** Runs an experiment in the page; returns its outputs row by row. */
function inPage({ model, values, inputs, outputs, rows }) {
  const given = (row) => inputs.map((name, index) => [name, row[index + 1]]);
  const plant = globalThis.pneumaticServo.start(6, model, new Map([...Object.entries(values), ...given(rows[0])]));
  const read = plant.reader(outputs);
  return rows.map((row) => {
    plant.advance(row[0]);
    plant.set(new Map(given(row)));
    return Array.from(read());
  });
}

test("every model under every law has the bits of the native library", async () => {
  const { page, close } = await open(browser, "#view=presliding");
  const all = experiments(await page.evaluate(() => globalThis.pneumaticServo.tables));
  assert.ok(all.length > 4 * 24, `${all.length} experiments`);
  assert.equal(new Set(all.map((experiment) => experiment.model)).size, 6);
  // One process for all: without optimization most of its time is the start.
  const whole = replay(all);
  for (const [place, experiment] of all.entries()) {
    const rows = await page.evaluate(inPage, experiment);
    const native = whole.slice(ROWS * place, ROWS * (place + 1));
    const name = `${experiment.model} ${JSON.stringify(experiment.values)}`;
    assert.deepEqual(rows.map((row) => row.map(bits).join(" ")), native, name);
    assert.ok(new Set(native).size > 20, `${name} moves`);
  }
  await close();
});

/** A file of comma-separated values as columns by name. */
function columns(csv) {
  const [head, ...rows] = csv.trimEnd().split("\n").map((line) => line.split(","));
  return new Map(head.map((name, index) => [name, rows.map((row) => row[index])]));
}

/** Compares the columns of a model, whose names begin with a prefix, with the library under the same inputs. */
function assertRepeated(csv, prefix, model, values, inputs) {
  const table = columns(csv);
  const outputs = [...table.keys()].filter(
    (name) => name.startsWith(prefix) && name !== "time" && !inputs.includes(name.slice(prefix.length)),
  );
  const count = table.get("time").length;
  const at = (name, row) => table.get(name)[row];
  const rows = Array.from({ length: count }, (_, row) => [
    at("time", row),
    ...inputs.map((name) => at(prefix + name, row)),
  ]);
  const native = replay([{ model, values, inputs, outputs: outputs.map((name) => name.slice(prefix.length)), rows }]);
  const page = rows.map((_, row) => outputs.map((name) => bits(Number(at(name, row)))).join(" "));
  assert.ok(count > 300 && outputs.length > 1, `${count} rows of ${outputs.length} columns`);
  assert.deepEqual(page, native);
}

const RUNS = [
  {
    name: "stick-slip",
    fragment: `&${CYLINDER}.friction.law=14&${CYLINDER}.supplyPressure=600000`,
    members: [["", CYLINDER, { "friction.law": 14, supplyPressure: 6e5 }, ["valveVoltage"]]],
  },
  {
    name: "two-laws",
    fragment: "&second=16",
    members: [
      ["Stribeck.", CYLINDER, { "friction.law": 7 }, ["valveVoltage"]],
      ["GMS.", CYLINDER, { "friction.law": 16 }, ["valveVoltage"]],
    ],
  },
  {
    name: "presliding",
    fragment: "&signal=drawn&FrictionBench.friction.law=15",
    members: [["", "FrictionBench", { "friction.law": 15, "bench.drive": 2 }, ["driveVelocity"]]],
  },
  {
    name: "closed-loop",
    fragment: "&PositionController.gain.position=20",
    members: [
      ["plant.", CYLINDER, {}, ["valveVoltage"]],
      [
        "controller.",
        "PositionController",
        { "gain.position": 20 },
        ["referencePosition", "position", "velocity"],
      ],
    ],
  },
];

for (const { name, fragment, members } of RUNS) {
  test(`the downloaded run of ${name} is that of the native library`, async () => {
    const { page, close } = await open(browser, `#view=${name}${fragment}`);
    if (name !== "presliding") await runFor(page, 0.4);
    const { name: file, text } = await download(page, "CSV");
    assert.match(file, new RegExp(`^${name}-[0-9a-f]{8}\\.csv$`));
    for (const member of members) assertRepeated(text, ...member);
    await close();
  });
}
