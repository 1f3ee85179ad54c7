// Parts of a fit by themselves: tables, units, columns.
import assert from "node:assert/strict";
import { test } from "node:test";
import { part } from "./part.mjs";

/** The units of the library that these tests need. */
const unit = (name, si, factor, offset = 0, offsetAboveAmbient = offset) => ({ name, si, factor, offset, offsetAboveAmbient });
const TABLES = {
  units: { m: { display: [{ name: "mm", factor: 1e3, offset: 0 }] }, Pa: { display: [{ name: "bar", factor: 1e-5, offset: 0 }] }, K: { display: [{ name: "degC", factor: 1, offset: -273.15 }] } },
  written: [
    ...[unit("m", "m", 1), unit("um", "m", 1e-6), unit("mm", "m", 1e-3), unit("s", "s", 1), unit("V", "V", 1), unit("degC", "K", 1, 273.15)],
    ...[unit("Pa", "Pa", 1), unit("bar", "Pa", 1e5), unit("barg", "Pa", 1e5, 101_325, 0), unit("bara", "Pa", 1e5, 0, -101_325)],
  ],
  spellings: { parts: [[" ", ""], ["\u00b5", "u"], ["(g)", "g"]], whole: [["sec", "s"]] },
};
const isUnit = (text) => ["s", "ms", "m", "mm", "bar", "Pa", "V", "N"].includes(text);
const near = (found, expected, within) => assert.ok(Math.abs(found - expected) <= within, `${found} is not ${expected}`);

async function read(text, file = "rig.csv") {
  const { readTable } = await part("fit/table");
  const table = await readTable(file, text, isUnit);
  return { ...table, columns: table.columns.map((column) => Array.from(column)), lines: Array.from(table.lines) };
}

test("a table is read as it is written: separators, decimal commas, comments, units behind names or below", async () => {
  const same = [
    "t,x[mm]\n0,1\n0.5,2.5\n",
    "\uFEFF# a recorder\n\nt;x (mm)\r\n0;1\r\n0,5;2,5\r\n",
    "t\tx\n% units\ns\tmm\n0\t1\n0.5\t2.5",
    "//\n  t   x[mm] \n 0  1\n 0.5  2.5\n",
    '"t","x[mm]"\n"0","1"\n"0.5","2.5"\n',
    "t,x[mm]\r0,1\r0.5,2.5\r",
    "Recorder 7;serial 12\nStarted;27.11.2026\nt;x / mm;\n0;1;\n0,5;2,5;\n",
    "Recorder 7, rig 2\nt,x\ns,mm\n0,1\n0.5,2.5\n",
  ];
  for (const text of same) {
    const { names, units, columns } = await read(text);
    assert.deepEqual([names, units[1], columns], [["t", "x"], "mm", [[0, 0.5], [1, 2.5]]], JSON.stringify(text));
  }
  const { lines, first } = await read("Recorder\n\n1 channel\nt,x in mm\n0,1\n0.5,2.5\n");
  assert.deepEqual([first, lines], [4, [5, 6]]);
  const { names, units } = await read("t,friction.gms.alpha[1],T [degC]\n0,1,2\n");
  assert.deepEqual([names, units], [["t", "friction.gms.alpha[1]", "T [degC]"], [null, null, null]]);
});

test("what is wrong with a table is named by line and column", async () => {
  const wrong = [
    ["t,x\n0,1\n\n1,abc\n", "rig.csv:4, column 2 (x): 'abc' is no number"],
    ["# c\nt,x\n0,1\n1,\n", "rig.csv:4, column 2 (x): '' is no number"],
    ["t,x\n0,nan\n", "rig.csv:2, column 2 (x): nan is not finite"],
    ["t,x\n0,1e999\n", "rig.csv:2, column 2 (x): 1e999 is not finite"],
    ["t,x\n0,0x10\n", "rig.csv:2, column 2 (x): '0x10' is no number"],
    ["t,x\n0,1\n1,2,3\n", "rig.csv:3: 3 values, but the header has 2 columns"],
    ["t,x\n0;1\n", "rig.csv:2: 1 values, but the header has 2 columns; the header is separated by commas, but this line has semicolons"],
    ["t,x\n,\n", "rig.csv:2, column 1 (t): '' is no number"],
    ['t,x\n0,1\n1,"2\n', "rig.csv:3: a quote is not closed"],
    ["t,x\n", "rig.csv: there are no rows below the header"],
    ["", "rig.csv: there are no lines but empty ones and comments"],
  ];
  for (const [text, message] of wrong) {
    await assert.rejects(read(text), (error) => {
      assert.equal(error.message.split("\n")[0], message, JSON.stringify(text));
      return true;
    });
  }
  // Of many rows, too, where the table is read piece by piece.
  const rows = Array.from({ length: 200_000 }, (_, row) => `${row},${row === 150_000 ? "x" : row * 0.5}`);
  await assert.rejects(read(`t,x\n${rows.join("\n")}\n`), { message: "rig.csv:150002, column 2 (x): 'x' is no number" });
});

test("values are turned into SI units, as exactly as they are written", async () => {
  const { toSi, unitsOf, plain, typedAs } = await part("units");
  const { scaleOf } = await part("fit/columns");
  const { typed } = await part("typed");
  const si = (value, unit, of, turned = false) => toSi(Float64Array.of(value), unitsOf(TABLES, of).get(unit), turned)[0];
  assert.equal(si(250, "mm", "m"), 0.25);
  assert.equal(si(250.061, "mm", "m"), 250.061 / 1000);
  assert.equal(si(3, "um", "m"), 3 / 1e6);
  near(si(6, "bar", "Pa"), 6e5, 1e-9);
  assert.equal(si(1, "barg", "Pa"), 201_325);
  assert.equal(si(20, "degC", "K"), 293.15);
  assert.equal(si(2, "m", "m", true), -2);
  const own = (text) => plain(TABLES.spellings, text);
  assert.deepEqual([own(" \u00b5m"), own("sec")], ["um", "s"]);
  assert.deepEqual([...unitsOf(TABLES, "m").keys()].slice(0, 2), ["m", "mm"]);
  // `pressure` of a bench counts above ambient.
  const above = (name) => scaleOf("pressure", unitsOf(TABLES, "Pa").get(name)).offset;
  assert.deepEqual([above("bar"), above("barg"), above("bara")], [0, 0, -101_325]);
  const bar = { name: "bar", factor: 1e-5, offset: 0 };
  for (const [text, value] of [["6 barg", 7.01325], ["6 bar (g)", 7.01325], ["600000 Pa", 6], ["6", 6]]) {
    near(typed(text, "bar", typedAs(TABLES, "Pa", bar), own), value, 1e-12);
  }
  near(typed("20 degC", "K", typedAs(TABLES, "K", { name: "K", factor: 1, offset: 0 })), 293.15, 1e-12);
});

test("names of columns tell what they are, and none is taken twice", async () => {
  const { proposed, signalsOf } = await part("fit/columns");
  const { TAKEN } = await part("fit/signals");
  const table = (names, units, ...columns) => ({
    file: "rig.csv",
    names,
    units,
    columns: columns.map((column) => Float64Array.from(column)),
    lines: Int32Array.of(2, 3, 5),
    first: 1,
  });
  const rig = table(["t", "x_mm", "u", "position", "p1"], [null, null, null, "mm", "bogus"], [0, 1, 2], [1, 2, 3], [0, 0, 0], [7, 8, 9], [1, 1, 1]);
  const columns = proposed(TABLES, rig, TAKEN.rig);
  assert.deepEqual([...columns].map(([signal, { place, unit }]) => [signal, place, unit]).sort(), [
    ["chamberA.pressure", 4, "Pa"],
    ["position", 3, "mm"],
    ["time", 0, "s"],
    ["valveVoltage", 2, "V"],
  ]);
  assert.deepEqual(Array.from(signalsOf(TABLES, rig, columns).get("position")), [0.007, 0.008, 0.009]);
  const back = table(["t", "x"], [null, null], [0, 1, 1], [1, 2, 3]);
  assert.throws(() => signalsOf(TABLES, back, proposed(TABLES, back, TAKEN.rig)), {
    message: "rig.csv:5, column t: time must rise, but 1 s follows 1 s",
  });
});

test("headers as recorders write them are recognised", async () => {
  const { proposed } = await part("fit/columns");
  const { TAKEN } = await part("fit/signals");
  const of = (names, units) => {
    const columns = proposed(TABLES, { file: "rig.csv", names, units, columns: [], lines: Int32Array.of(), first: 1 }, TAKEN.rig);
    return Object.fromEntries([...columns].map(([signal, { place, unit }]) => [signal, `${place} ${unit}`]));
  };
  const expected = { time: "0 s", valveVoltage: "1 V", position: "2 mm", "chamberA.pressure": "3 bar", "chamberB.pressure": "4 bar" };
  const units = ["s", "V", "mm", "bar", "bar"];
  assert.deepEqual(of(["Zeit", "Valve voltage", "Stroke", "Pressure A", "Pressure B"], units), expected);
  assert.deepEqual(of(["Time ", "Spannung", "Hub", "Druck A", "Kammer B Druck"], units), expected);
  assert.deepEqual(of(["t", "valve-signal", "piston_position", "P1", "chamber 2"], units), expected);
  // Which pressure it is has to be told.
  assert.deepEqual(of(["t", "u", "x", "pressure", "pressure C"], units), { time: "0 s", valveVoltage: "1 V", position: "2 mm" });
});
