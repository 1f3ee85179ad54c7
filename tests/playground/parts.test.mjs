// Parts of the page by themselves, without a browser: what is kept of a run, what an input does, how fast time passes.
import assert from "node:assert/strict";
import { test } from "node:test";
import { part } from "./part.mjs";

test("a run of more than two minutes loses its beginning, and says so", async () => {
  const { Recording } = await part("record");
  const recording = new Recording(["time", "square"]);
  const push = (from, to) => {
    for (let row = from; row < to; row += 1) recording.push([row, row * row]);
  };
  push(0, 120_000);
  assert.deepEqual([recording.isCut, recording.rows, recording.column("time")[0]], [false, 120_000, 0]);
  push(120_000, 120_001);
  assert.deepEqual([recording.isCut, recording.rows], [true, 90_001]);
  assert.deepEqual([recording.column("time")[0], recording.last("time")], [30_000, 120_000]);
  const [times, squares] = ["time", "square"].map((name) => recording.column(name));
  assert.ok(times.every((time, row) => time === 30_000 + row && squares[row] === time * time));
  assert.deepEqual([0, 30_000.5, 70_000, 1e9].map((time) => recording.rowAt(time)), [0, 0, 40_000, 90_000]);
  const lines = recording.csv().trimEnd().split("\n");
  assert.deepEqual([lines.length, lines[0], lines[1]], [90_002, "time,square", "30000,900000000"]);
});

test("a recording in which nothing is yet has no last value", async () => {
  const { Recording } = await part("record");
  const recording = new Recording(["time"]);
  assert.deepEqual([recording.rows, recording.last("time"), recording.csv()], [0, NaN, "time\n"]);
});

/** The inverse of a sine is a ramp up and down. */
const ramp = (phase) => (2 / Math.PI) * Math.asin(Math.sin(2 * Math.PI * phase));

test("inputs follow their formulas", async () => {
  const { at, along } = await part("signal");
  const points = Array.from({ length: 101 }, (_, index) => (index === 25 ? 1 : index / 200));
  const of = (kind) => ({ kind, level: 5, amplitude: 2, period: 4, points, centring: 0 });
  for (const time of [0, 0.3, 1, 1.7, 2, 2.4, 3, 3.9, 4, 7.3, 401.2]) {
    const phase = time / 4;
    assert.equal(at(of("constant"), time), 5);
    for (const [kind, expected] of [["sine", Math.sin(2 * Math.PI * phase)], ["ramp", ramp(phase)]]) {
      const value = at(of(kind), time);
      assert.ok(Math.abs(value - (5 + 2 * expected)) < 1e-9, `${kind} at ${time} s: ${value}`);
    }
  }
  // A drawing goes on straight lines from point to point, and repeats.
  for (const [time, expected] of [[0, 0], [1, 1], [0.98, 0.56], [1.02, 0.565], [5, 1]]) {
    const value = at(of("drawn"), time);
    assert.ok(Math.abs(value - (5 + 2 * expected)) < 1e-9, `drawn at ${time} s: ${value}`);
  }
  assert.deepEqual([along([1, 3], 0), along([1, 3], 0.25), along([1, 3], 1)], [1, 1.5, 3]);
});

test("the input of a cylinder is drawn back to where the run began", async () => {
  const { CentredInput } = await part("centring");
  const input = new CentredInput(() => ({ kind: "constant", level: 5, amplitude: 0, period: 1, points: [], centring: 2 }), 1);
  const read = (position) => ({ read: () => [NaN, position] });
  assert.deepEqual([input.at(0, read(0.3), 0), input.at(1, read(0.4), 0), input.at(2, read(0.2), 0)], [5, 4.8, 5.2]);
});

test("numbers are read as people type them", async () => {
  const { typed } = await part("typed");
  const bar = [{ name: "bar", factor: 1e-5, offset: 0 }];
  for (const [text, value] of [["6 bar", 6e5], ["6,5bar", 6.5e5], ["600000", 6e5], ["1e5 Pa", 1e5], [" −2,5 ", -2.5]]) {
    assert.equal(typed(text, "Pa", bar), value, text);
  }
  assert.equal(typed("20 degC", "K", [{ name: "degC", factor: 1, offset: -273.15 }]), 293.15);
  for (const [text, message] of [["abc", /“abc” is no number/], ["", /“” is no number/], ["6 psi", /psi does not fit, its unit is Pa or bar/], ["1,000.5", /does not fit/], ["1e999", /too large/]]) {
    assert.throws(() => typed(text, "Pa", bar), message, text);
  }
  // 600 kPa are meant, not 600 bar.
  const plausible = { largest: 100, range: "1.5 to 10 bar" };
  const wrong = /“600” has no unit and would be 600 bar, far beyond 1\.5 to 10 bar: write the unit, say 600 bar/;
  assert.throws(() => typed("600", "bar", [], undefined, plausible), wrong);
  assert.deepEqual(["600 bar", "60"].map((text) => typed(text, "bar", [], undefined, plausible)), [600, 60]);
});

test("a refusal writes a number of very many digits short", async () => {
  const { Refusal } = await part("library");
  assert.equal(new Refusal(`valve.C = 1${"0".repeat(99)} is refused: it must be at most 0.001`).message, "valve.C = 1e+99 is refused: it must be at most 0.001");
});

test("sticking, break-away and end stop are found in a recording, and a path has a gap where the velocity jumps", async () => {
  const { Recording } = await part("record");
  const { episodes, withoutJumps } = await part("episodes");
  const recording = new Recording(["time", "position", "sticking"]);
  const rows = [[0.1, 1], [0.1, 1], [0.2, 0], [0.5, 0], [0.4, 0], [0.3, 1], [0.3, 1]];
  rows.forEach(([position, sticking], row) => recording.push([row, position, sticking]));
  assert.deepEqual(episodes(recording, 0, 0.5), { sticking: [[0, 2], [5, 6]], breakAways: [2], stops: [[3, 4]] });
  assert.deepEqual([...withoutJumps(Float64Array.of(0, 1, 2, 9, 10, 9.5))], [0, 1, NaN, 9, 10, 9.5]);
});

test("axes are divided at round values", async () => {
  const { ticks } = await part("svg");
  assert.deepEqual(ticks([-0.2, 1.1]), [0, 0.5, 1]);
  assert.deepEqual(ticks([0, 12]), [0, 2, 4, 6, 8, 10, 12]);
  assert.deepEqual(ticks([289.97, 290.03]), [289.97, 289.98, 289.99, 290, 290.01, 290.02, 290.03]);
});

/** Shows frames every 16 ms for some time; steps take some time each. */
async function paced({ seconds, speed = 1, cost = 0 }) {
  const { Clock } = await part("clock");
  const clock = new Clock(1e-3);
  clock.speed = speed;
  let [now, steps] = [0, 0];
  const real = globalThis.performance;
  const put = (value) => Object.defineProperty(globalThis, "performance", { value, configurable: true });
  put({ now: () => now });
  try {
    for (let frame = 0; frame <= (seconds * 1000) / 16; frame += 1) {
      now = frame * 16;
      clock.frame(now, () => {
        steps += 1;
        now += cost;
      });
    }
  } finally {
    put(real);
  }
  return { steps, dropped: clock.dropped, clock };
}

test("real time is kept where steps are quick, at any speed", async () => {
  for (const speed of [1, 0.5, 0.1, 2]) {
    const { steps, dropped } = await paced({ seconds: 8, speed });
    assert.ok(Math.abs(steps - 8000 * speed) <= 1 && dropped === 0, `${steps} steps, ${dropped} dropped`);
  }
});

test("steps that do not fit into a frame are counted, not made up for", async () => {
  const { steps, dropped } = await paced({ seconds: 8, cost: 1 });
  // 10 of 16 ms fit into the 9 ms of a frame; the last step is begun before they have passed.
  assert.ok(Math.abs(steps - 5000) <= 10 && Math.abs(steps + dropped - 8000) <= 16, `${steps} and ${dropped}`);
});

test("a pause is not made up for", async () => {
  const { clock } = await paced({ seconds: 1 });
  let steps = 0;
  clock.pause();
  clock.frame(60_000, () => (steps += 1));
  assert.equal(steps, 0);
  clock.frame(60_016, () => (steps += 1));
  assert.ok(Math.abs(steps - 16) <= 1, `${steps} steps`);
});
