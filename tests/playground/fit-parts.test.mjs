// Parts of a fit by themselves: tables, units, sensors, distributions, small matrices.
import assert from "node:assert/strict";
import { test } from "node:test";
import { part } from "./part.mjs";

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
  ];
  for (const text of same) {
    const { names, units, columns } = await read(text);
    assert.deepEqual([names, units[1], columns], [["t", "x"], "mm", [[0, 0.5], [1, 2.5]]], JSON.stringify(text));
  }
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
  const { toSi, unitsOf, plain } = await part("fit/units");
  const tables = {
    units: {
      m: { display: [{ name: "mm", factor: 1e3, offset: 0 }] },
      Pa: { display: [{ name: "bar", factor: 1e-5, offset: 0 }] },
      K: { display: [{ name: "degC", factor: 1, offset: -273.15 }] },
    },
  };
  const si = (value, unit, of, turned = false) => toSi(Float64Array.of(value), unitsOf(tables, of).get(unit), turned)[0];
  assert.equal(si(250, "mm", "m"), 0.25);
  assert.equal(si(250.061, "mm", "m"), 250.061 / 1000);
  assert.equal(si(3, "um", "m"), 3 / 1e6);
  near(si(6, "bar", "Pa"), 6e5, 1e-9);
  assert.equal(si(1, "barg", "Pa"), 201_325);
  assert.equal(si(20, "degC", "K"), 293.15);
  assert.equal(si(2, "m", "m", true), -2);
  assert.equal(plain(" \u00b5m"), "um");
  assert.deepEqual([...unitsOf(tables, "m").keys()].slice(0, 2), ["m", "mm"]);
});

test("names of columns tell what they are, and none is taken twice", async () => {
  const { proposed, signalsOf } = await part("fit/columns");
  const { TAKEN } = await part("fit/signals");
  const tables = { units: { m: { display: [{ name: "mm", factor: 1e3, offset: 0 }] }, s: { display: [] }, V: { display: [] }, Pa: { display: [] }, N: { display: [] }, "m/s": { display: [] } } };
  const table = (names, units, ...columns) => ({
    file: "rig.csv",
    names,
    units,
    columns: columns.map((column) => Float64Array.from(column)),
    lines: Int32Array.of(2, 3, 5),
    first: 1,
  });
  const rig = table(["t", "x_mm", "u", "position", "p1"], [null, null, null, "mm", "bogus"], [0, 1, 2], [1, 2, 3], [0, 0, 0], [7, 8, 9], [1, 1, 1]);
  const columns = proposed(tables, rig, TAKEN.rig);
  assert.deepEqual([...columns].map(([signal, { place, unit }]) => [signal, place, unit]).sort(), [
    ["chamberA.pressure", 4, "Pa"],
    ["position", 3, "mm"],
    ["time", 0, "s"],
    ["valveVoltage", 2, "V"],
  ]);
  assert.deepEqual(Array.from(signalsOf(tables, rig, columns).get("position")), [0.007, 0.008, 0.009]);
  const back = table(["t", "x"], [null, null], [0, 1, 1], [1, 2, 3]);
  assert.throws(() => signalsOf(tables, back, proposed(tables, back, TAKEN.rig)), {
    message: "rig.csv:5, column t: time must rise, but 1 s follows 1 s",
  });
});

test("headers as recorders write them are recognised", async () => {
  const { proposed } = await part("fit/columns");
  const { TAKEN } = await part("fit/signals");
  const display = (name, factor) => ({ display: [{ name, factor, offset: 0 }] });
  const tables = { units: { m: display("mm", 1e3), Pa: display("bar", 1e-5), s: { display: [] }, V: { display: [] }, N: { display: [] }, "m/s": { display: [] } } };
  const of = (names, units) => {
    const columns = proposed(tables, { file: "rig.csv", names, units, columns: [], lines: Int32Array.of(), first: 1 }, TAKEN.rig);
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

test("a fit is judged by what it leaves, and not by whether its search has ended", async () => {
  const { verdict } = await part("fit/verdict");
  const time = Float64Array.from({ length: 400 }, (_, row) => row / 100);
  const noisy = time.map((value, row) => Math.sin(value) + 1e-3 * Math.sin(1e4 * row * row));
  const judged = (rms, changed = {}) =>
    verdict({
      converged: true, message: "ended", estimates: [], rms: new Map([["position", rms]]), holdOutRms: new Map(),
      courses: [{ time, measured: new Map([["position", noisy]]), simulated: new Map() }], ...changed,
    });
  assert.equal(judged(1e-3).light, "green");
  assert.equal(judged(0.05).light, "yellow");
  const missed = judged(0.6);
  assert.equal(missed.light, "red");
  assert.match(missed.findings[0].text, /position.*varies by.*supply, mass and bore/);
  assert.equal(judged(1e-3, { converged: false }).light, "red");
  assert.equal(judged(1e-3, { holdOutRms: new Map([["position", 4e-3]]) }).light, "red");
  assert.equal(judged(1e-3, { estimates: [{ name: "friction.stribeck.Fc", undetermined: "at a bound" }] }).light, "yellow");
});

test("the normal distribution and Student's are those of the tables", async () => {
  const { logNormal, student } = await part("fit/normal");
  // scipy.special.log_ndtr
  for (const [x, expected] of [
    [-40, -804.6084420137538], [-10, -53.23128515051247], [-3, -6.607726221510349], [-2.9, -6.284058234947419],
    [-1, -1.8410216450092636], [0, -0.6931471805599453], [1, -0.17275377902344985], [3, -0.0013508099647481923],
    [10, -7.619853024160525e-24],
  ]) {
    near(logNormal(x), expected, 2e-13 * Math.abs(expected));
  }
  // scipy.stats.t.ppf(0.975, freedom); the algorithm has six digits.
  for (const [freedom, expected] of [[1, 12.706204736174694], [2, 4.302652729911275], [3, 3.182446305284263], [5, 2.570581835636314], [19, 2.093024054408263], [6297, 1.9603407861160198]]) {
    near(student(0.95, freedom), expected, 5e-6 * expected);
  }
});

test("noise and the step of a converter are found, and parabolas are followed to the ends", async () => {
  const { noise, parabolas, follow } = await part("fit/smoothing");
  const { converter, Sensor } = await part("fit/sensor");
  let state = 1;
  const random = () => (state = (state * 16807) % 2147483647) / 2147483647;
  const normal = () => Math.sqrt(-2 * Math.log(random())) * Math.cos(2 * Math.PI * random());
  const true_ = Float64Array.from({ length: 4000 }, (_, row) => 0.1 * Math.sin(row / 300));
  const noisy = true_.map((value) => value + 1e-5 * normal());
  // The deviation of the median of 4000 magnitudes is about 2 %.
  near(noise(noisy), 1e-5, 1e-6);
  const step = 1.22e-4;
  const rounded = noisy.map((value) => step * Math.round(value / step));
  near(converter(rounded), step, 1e-9);
  assert.equal(converter(noisy), 0);
  const sensor = Sensor.of([rounded]).withNoiseOf(rounded.map((value, row) => value - true_[row]));
  assert.ok(sensor.isCoarse && Math.abs(sensor.noise - 1e-5) < 2e-6, `${sensor.noise}`);
  // The derivatives of the residuals, against differences.
  for (const difference of [-3e-4, -7e-5, 2e-6, 5e-5, 8e-5]) {
    const [low, high] = [-1e-9, 1e-9].map((by) => sensor.residuals(Float64Array.of(difference + by))[0]);
    const slope = sensor.slopes(Float64Array.of(difference))[0];
    near((high - low) / 2e-9, slope, 1e-3 * Math.abs(slope) + 1);
  }
  const square = Float64Array.from({ length: 50 }, (_, row) => 3 + 2 * row - 0.5 * row * row);
  const { smooth, slope } = parabolas(square, 0.1, 1.1);
  for (const row of [0, 3, 25, 49]) {
    near(smooth[row], square[row], 1e-9);
    near(slope[row], (2 - row) / 0.1, 1e-8);
  }
  assert.deepEqual(Array.from(follow(Float64Array.of(0, 0.5, 2, 1.5, -2), 1)), [0, 0, 1, 1, -1]);
});

test("triangles have the products of the columns, pseudo-inverses solve, factors are not negative", async () => {
  const { triangle, pseudoInverse } = await part("fit/matrix");
  const { nonNegative } = await part("fit/guess");
  const columns = [1, 2, 3].map((power) => Float64Array.from({ length: 2500 }, (_, row) => Math.sin(row * power) + power));
  const found = triangle(columns);
  const dot = (a, b) => a.reduce((total, value, row) => total + value * b[row], 0);
  const product = found.transpose().mmul(found);
  columns.forEach((one, i) => columns.forEach((other, j) => near(product.get(i, j), dot(one, other), 1e-8)));
  const inverse = pseudoInverse(found, 1e-12).mmul(found);
  for (const i of [0, 1, 2]) for (const j of [0, 1, 2]) near(inverse.get(i, j), Number(i === j), 1e-9);
  const right = columns[0].map((value, row) => 2 * value - 0.5 * columns[1][row] + 3 * columns[2][row]);
  const factors = nonNegative(columns, right);
  assert.ok(factors[1] === 0 && factors.every((value) => value >= 0), String(factors));
  const fitted = nonNegative(columns, columns[0].map((value, row) => 2 * value + 3 * columns[2][row]));
  fitted.forEach((value, index) => near(value, [2, 0, 3][index], 1e-6));
});
