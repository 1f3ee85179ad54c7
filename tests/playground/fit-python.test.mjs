// A fit of the page agrees with the Python package: the program that the page exports finds the same values.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, test } from "node:test";
import { download, launch, open } from "./browser.mjs";
import { CYLINDER, drop, fitted, RIG } from "./fits.mjs";
import { valuesOf } from "./python.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

/** Both are one crate, on data that one reads as the other does: values are apart by no more than this share of half an interval. */
const APART = 1e-3;
const WIDTH = 1e-3;

/** Numbers that are the same each time. */
function normals() {
  let state = 7;
  const random = () => (state = (state * 16807) % 2147483647) / 2147483647;
  return () => Math.sqrt(-2 * Math.log(random())) * Math.cos(2 * Math.PI * random());
}

/** A bench that sweeps back and forth, under a load that grows with a pressure. */
function bench() {
  const normal = normals();
  const rows = Array.from({ length: 3001 }, (_, row) => {
    const time = row * 1e-3;
    const speed = 0.03 * Math.cos(3 * time) + 0.012 * Math.cos(11 * time);
    const pressure = 2 + Math.sin(2 * time);
    const friction = (5 + 3 * Math.exp(-((speed / 0.01) ** 2))) * Math.tanh(speed / 1e-5) + 40 * speed;
    const force = (1 + 0.1 * pressure) * friction + 20 * pressure + 0.1 * normal();
    const position = 10 * Math.sin(3 * time) + (12 / 11) * Math.sin(11 * time);
    return [time.toFixed(3), position.toFixed(6), force.toFixed(5), pressure.toFixed(5)].join(",");
  });
  return `t,x[mm],f,p[bar]\n${rows.join("\n")}\n`;
}

/** Three springs that slip, moved back and forth by some of their deflections. */
function springs() {
  const normal = normals();
  const elements = [[2e5, 0.6], [1e5, 1], [4e4, 1.2]].map(([stiffness, limit]) => ({ stiffness, limit, force: 0 }));
  let last = 0;
  const rows = Array.from({ length: 3001 }, (_, row) => {
    const time = row * 1e-3;
    const position = 25e-6 * Math.sin(3 * time) + 15e-6 * Math.sin(10 * time);
    for (const element of elements) {
      const force = element.force + element.stiffness * (position - last);
      element.force = Math.min(Math.max(force, -element.limit), element.limit);
    }
    last = position;
    const force = elements.reduce((total, element) => total + element.force, 0) + 0.01 * normal();
    return [time.toFixed(3), (1e6 * position).toFixed(5), force.toFixed(5)].join(",");
  });
  return `t,x[um],Ff\n${rows.join("\n")}\n`;
}

const free = (names) => names.join("+");
const STRIBECK = ["Fs", "Fc", "vs", "sigma2"].map((name) => `friction.stribeck.${name}`);
const FITS = [
  {
    title: "the rig under Stribeck",
    file: "rig.csv",
    text: () => readFile(RIG, "utf8"),
    link: `experiment=rig&free=${free([...STRIBECK, "valve.deadZone", "valve.C"])}&${CYLINDER}.friction.law=7&${CYLINDER}.supplyPressure=600000`,
  },
  {
    title: "the rig under LuGre, with a lag of the sensor",
    file: "rig.csv",
    text: () => readFile(RIG, "utf8"),
    link:
      `experiment=rig&free=${free(["friction.lugre.Fs", "friction.lugre.Fc", "friction.lugre.sigma2", "valve.deadZone", "delay.position"])}` +
      `&${CYLINDER}.friction.law=14&${CYLINDER}.supplyPressure=600000&${CYLINDER}.valve.C=4.4e-9`,
  },
  {
    title: "a seal under pressure",
    file: "bench.csv",
    text: bench,
    link: `experiment=motion&free=${free([...STRIBECK, "area", "friction.kappaA"])}&FrictionBench.friction.law=7`,
    play: "0",
  },
  {
    title: "a bench under Maxwell's elements",
    file: "springs.csv",
    text: springs,
    link: "experiment=motion&FrictionBench.friction.law=17&FrictionBench.friction.maxwellSlip.N=3",
    play: "0",
  },
];

for (const { title, file, text, link, play } of FITS) {
  test(`${title}: values and intervals are those of Python`, async (context) => {
    const { page, close } = await open(browser, `#view=fit&${link}`);
    const content = await text();
    await drop(page, file, content);
    await page.waitForSelector("table.columns");
    if (play !== undefined) {
      await page.getByText("Options of the fit").click();
      await page.getByLabel("Play", { exact: true }).fill(play);
      await page.getByLabel("Play", { exact: true }).press("Enter");
    }
    const found = await fitted(page);
    const program = await download(page, "Python");
    await close();
    // The interval of a parameter that is not identifiable has no end, which JSON cannot write.
    const shown = "print(json.dumps([[e.value, e.low, min(e.high, 1e300)] for e in found.parameters.values()]))";
    const expected = await valuesOf({ name: file, text: content }, `${program.text}\nimport json\n${shown}\n`);
    assert.equal(found.size, expected.length);
    let [furthest, told] = [0, 0];
    for (const [index, [name, { value, low, high }]] of [...found].entries()) {
      const [own, least, most] = expected[index];
      if (most === 1e300) {
        assert.equal(high, Infinity, name);
        continue;
      }
      const half = (most - least) / 2;
      const apart = Math.abs(value - own) / half;
      furthest = Math.max(furthest, apart);
      told += 1;
      assert.ok(apart <= APART, `${name} = ${value}, in Python ${own} [${least}, ${most}]`);
      assert.ok(Math.abs((high - low) / 2 - half) <= WIDTH * half, `${name}: [${low}, ${high}], in Python [${least}, ${most}]`);
    }
    assert.ok(told >= 4, `${told} values are told by the data`);
    context.diagnostic(`values are apart by ${furthest.toFixed(4)} of half an interval at most`);
  });
}
