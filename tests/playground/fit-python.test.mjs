// A fit of the page is that of the Python package to the last bit: the program that the page exports finds the same values.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, test } from "node:test";
import { download, launch, open } from "./browser.mjs";
import { CYLINDER, drop, fitted, RIG } from "./fits.mjs";
import { valuesOf } from "./python.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

/** The end of an interval that has none, which JSON cannot write. */
const ENDLESS = 1e300;

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

/** An axis of 20 kg that a measured force moves, with Coulomb friction of 15 N and 60 N.s/m. */
function axis() {
  const normal = normals();
  const rows = Array.from({ length: 2001 }, (_, row) => {
    const time = row * 2e-3;
    const speed = 0.3 * Math.cos(3 * time) + 0.22 * Math.cos(11 * time);
    const force = 20 * (-0.9 * Math.sin(3 * time) - 2.42 * Math.sin(11 * time)) + 15 * Math.sign(speed) + 60 * speed;
    const position = 1e3 * (0.1 * Math.sin(3 * time) + 0.02 * Math.sin(11 * time)) + 5e-3 * normal();
    return [time.toFixed(3), position.toFixed(5), force.toFixed(5)].join(",");
  });
  return `t,x[mm],F[N]\n${rows.join("\n")}\n`;
}

/** A rotor of 0.02 kg.m2 under the current of a motor of 0.5 N.m/A, with friction of 0.2 N.m and 0.05 N.m.s/rad. */
function rotor() {
  const normal = normals();
  const rows = Array.from({ length: 2001 }, (_, row) => {
    const time = row * 2e-3;
    const speed = 12 * Math.cos(4 * time) + 9 * Math.cos(11 * time);
    const torque = 0.02 * (-48 * Math.sin(4 * time) - 99 * Math.sin(11 * time)) + 0.2 * Math.sign(speed) + 0.05 * speed;
    const angle = 3 * Math.sin(4 * time) + (9 / 11) * Math.sin(11 * time);
    return [time.toFixed(3), ((180 / Math.PI) * angle + 0.005 * normal()).toFixed(4), ((1e3 * torque) / 0.5).toFixed(2)].join(",");
  });
  return `t,x[°],f[mA]\n${rows.join("\n")}\n`;
}

/** A table of a seal bench: friction at eleven speeds in both directions and three pressures, each twice. */
function seal() {
  const normal = normals();
  const speeds = [0.2, 0.5, 1, 2, 4, 7, 12, 20, 35, 60, 100].flatMap((speed) => [-speed, speed]);
  const rows = [0, 2, 4].flatMap((pressure) =>
    [...speeds, ...speeds].map((speed) => {
      const dry = (8 + 4 * Math.exp(-((speed / 10) ** 2))) * (1 + 0.2 * pressure);
      const friction = Math.sign(speed) * dry + 0.04 * speed + 0.1 * normal();
      return [speed, pressure, friction.toFixed(4)].join(",");
    }),
  );
  return `v[mm/s],p[bar],Ff[N]\n${rows.join("\n")}\n`;
}

/** The rig, whose position is read in volts: 10 V are 500 mm. */
async function inVolts() {
  const [, ...rows] = (await readFile(RIG, "utf8")).trimEnd().split("\n");
  const read = ([t, u, x, a, b]) => [t, u, (x / 50).toFixed(5), a, b].join(",");
  return ["t,u,x [V],pA [bar],pB [bar]", ...rows.map((row) => read(row.split(",")))].join("\n");
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
    title: "the rig in segments, with a voltage on a smooth curve",
    file: "rig.csv",
    text: () => readFile(RIG, "utf8"),
    link: `experiment=rig&free=${free(STRIBECK)}&${CYLINDER}.friction.law=7&${CYLINDER}.supplyPressure=600000&inputs=smooth&segment=1.5&starts=0`,
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
    link: `experiment=motion&free=${free([...STRIBECK, "area", "friction.kappaA"])}&FrictionBench.friction.law=7&play=0`,
  },
  {
    title: "a bench under Maxwell's elements",
    file: "springs.csv",
    text: springs,
    link: "experiment=motion&FrictionBench.friction.law=17&FrictionBench.friction.maxwellSlip.N=3&play=0",
  },
  {
    title: "an axis that a force moves",
    file: "axis.csv",
    text: axis,
    link: `experiment=force&free=${free(["mass", "friction.coulomb.Fc", "friction.coulomb.sigma2"])}&FrictionBench.friction.law=2`,
    true: { mass: 20, "friction.coulomb.Fc": 15, "friction.coulomb.sigma2": 60 },
  },
  {
    title: "an axis whose force is not smoothed and runs on straight lines, in segments",
    file: "axis.csv",
    text: axis,
    link: `experiment=force&free=${free(["mass", "friction.coulomb.Fc", "offset.force"])}&FrictionBench.friction.law=2&smoothing=off&inputs=lines&segment=0.4&width=0.03&starts=0`,
  },
  {
    title: "a rotor under the current of a motor",
    file: "rotor.csv",
    text: rotor,
    link: `experiment=force&free=${free(["gain.force", "friction.coulomb.Fc", "friction.coulomb.sigma2", "offset.force"])}&FrictionBench.friction.law=2&known.mass=0.02`,
    true: { "gain.force": 0.5, "friction.coulomb.Fc": 0.2, "friction.coulomb.sigma2": 0.05 },
    units: ["N.m/A", "N.m", "N.m.s/rad", "A"],
  },
  {
    title: "points of a seal bench",
    file: "seal.csv",
    text: seal,
    link: `experiment=points&free=${free([...STRIBECK, "friction.kappaA"])}&FrictionBench.friction.law=7`,
    true: { "friction.stribeck.Fs": 12, "friction.stribeck.Fc": 8, "friction.stribeck.vs": 0.01, "friction.stribeck.sigma2": 40, "friction.kappaA": 2e-6 },
  },
  {
    title: "the mechanical half of the rig",
    file: "rig.csv",
    text: () => readFile(RIG, "utf8"),
    link: `experiment=mechanical&free=${free(STRIBECK)}&${CYLINDER}.friction.law=7`,
  },
  {
    title: "the pneumatic half of the rig, whose position is read in volts",
    file: "rig.csv",
    text: inVolts,
    calibration: "0..10 V = 0..500 mm",
    link: `experiment=pneumatic&free=${free(["valve.deadZone", "valve.C"])}&${CYLINDER}.supplyPressure=600000`,
  },
];

for (const { title, file, text, link, calibration, true: meant, units } of FITS) {
  test(`${title}: values and intervals are those of Python to the last bit`, async () => {
    const { page, close } = await open(browser, `#view=fit&${link}`);
    const content = await text();
    await drop(page, file, content);
    await page.waitForSelector("table.columns");
    if (calibration !== undefined) {
      await page.getByLabel("Column of position").selectOption("2");
      await page.getByLabel("Unit of position").selectOption("two points");
      await page.getByLabel("Calibration of position").fill(calibration);
      await page.getByLabel("Calibration of position").press("Enter");
      await page.waitForSelector("[data-finding]", { state: "detached" });
    }
    const found = await fitted(page);
    const notes = await page.locator(".notes li").allTextContents();
    assert.ok(notes.every((note) => !note.toLowerCase().startsWith(file) || note.startsWith(file)), notes.join("\n"));
    for (const [name, value] of Object.entries(meant ?? {})) {
      const { low, high } = found.get(name);
      assert.ok(low < value && value < high, `${name} = ${value} is not within [${low}, ${high}]`);
    }
    const shownUnits = await page.locator("tr[data-name] td:last-child").allTextContents();
    const program = await download(page, "Python");
    await close();
    const shown = `print(json.dumps([[e.value, e.low, min(e.high, ${ENDLESS}), e.unit] for e in found.parameters.values()]))`;
    const expected = await valuesOf({ name: file, text: content }, `${program.text}\nimport json\n${shown}\n`);
    assert.equal(found.size, expected.length);
    for (const [index, [name, { value, low, high }]] of [...found].entries()) {
      const [own, least, most] = expected[index];
      assert.deepEqual([value, low, high], [own, least, most === ENDLESS ? Infinity : most], name);
    }
    if (units) assert.deepEqual([shownUnits, expected.map(([, , , unit]) => unit)], [units, units]);
    const told = expected.filter(([, , most]) => most !== ENDLESS).length;
    assert.ok(told >= Math.min(found.size, 4), `${told} values are told by the data`);
  });
}
