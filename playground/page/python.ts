// Snippets for the Python package that repeat a run.

import { isFormula, type Signal } from "./signal";
import { items, model, variable, type Tables } from "./tables";

/** A dictionary of values: items of enumerations by name, what is true or false as that, and further lines. */
export function dictionary(tables: Tables, name: string, values: ReadonlyMap<string, number>, ...further: string[]): string {
  const lines = [...values].map(([key, value]) => {
    const of = variable(model(tables, name), key);
    const item = items(tables, of).find((candidate) => candidate.id === value);
    const text = item ? JSON.stringify(item.name) : of.kind === "Boolean" ? (value ? "True" : "False") : number(value);
    return `    ${JSON.stringify(key)}: ${text},\n`;
  });
  lines.push(...further.map((line) => `    ${line},\n`));
  return lines.length ? `{\n${lines.join("")}}` : "{}";
}

const number = (value: number): string => String(value);

const IMPORTS = "import matplotlib.pyplot as plt\nimport numpy as np\nimport pneumatic_servo as ps\n\n";
const SHOWN = 'plt.xlabel("time (s)"), plt.ylabel("position (mm)"), plt.legend(), plt.show()\n';

/** The downloaded file, and one of its columns. */
const table = (csv: string): string => `table = np.genfromtxt("${csv}", delimiter=",", names=True, deletechars="")\n`;
const column = (name: string): string => `table[${JSON.stringify(name)}]`;

/** An input over the times `t` by a formula. */
const formula = ({ level, amplitude, period }: Signal): string =>
  `u = ${level} + ${amplitude} * np.sin(2 * np.pi * t / ${period})\n`;

/**
 * Runs of one model with one input, which is a formula or, with a drawing, a slider or a feedback, a column of the
 * downloaded file. Of each run: its name in the program, its values, and what its columns begin with.
 */
export function oneModel(
  tables: Tables,
  name: string,
  runs: readonly (readonly [string, ReadonlyMap<string, number>, string])[],
  input: { variable: string; signal: Signal; isPushed: boolean },
  rows: number,
  csv: string,
): string {
  const isStated = isFormula(input.signal);
  const inputsOf = (prefix: string) => {
    const course = isStated ? "u" : column(prefix + input.variable);
    const pushed = input.isPushed ? `, "externalForce": (t, ${column(`${prefix}externalForce`)})` : "";
    return `{${JSON.stringify(input.variable)}: (t, ${course})${pushed}}`;
  };
  const from = isStated && !input.isPushed ? "" : `  # as many rows as ${csv} has`;
  const lines = [
    `t = np.arange(${rows}) * 1e-3${from}\n`,
    isStated ? formula(input.signal) : "",
    isStated && !input.isPushed ? "" : table(csv),
    `plant = ps.Model(${JSON.stringify(name)})\n`,
    ...runs.map(
      ([variable, values, prefix]) =>
        `${variable} = plant.simulate(${dictionary(tables, name, values)}, ` +
        `inputs=${inputsOf(prefix)}, stop=t[-1], step=1e-3)\n`,
    ),
  ];
  const curves = runs.map(([variable]) => `plt.plot(t, 1e3 * ${variable}["position"], label="${variable}")\n`);
  const ends = runs.map(([variable]) => `print(f"${variable}: {1e3 * ${variable}['position'][-1]:.3f} mm at {t[-1]:.3f} s")\n`);
  return IMPORTS + [...lines, ...ends, ...curves, SHOWN].join("");
}

/** The closed loop, stepped as a host does it: each gets what the other shows at the same instant. */
export function closedLoop(
  tables: Tables,
  cylinder: readonly [string, ReadonlyMap<string, number>],
  controller: readonly [string, ReadonlyMap<string, number>],
  signal: Signal,
  rows: number,
  csv: string,
  isPushed: boolean,
): string {
  const isStated = isFormula(signal);
  const course = isStated ? formula(signal) : `u = ${column("controller.referencePosition")}\n`;
  const pushes = isPushed ? `    plant["externalForce"] = table["plant.externalForce"][row]\n` : "";
  return `${IMPORTS}t = np.arange(${rows}) * 1e-3
${isStated && !isPushed ? "" : table(csv)}${course}plant = ps.Model(${JSON.stringify(cylinder[0])}).start(${dictionary(tables, ...cylinder)})
controller = ps.Model(${JSON.stringify(controller[0])}).start(${dictionary(tables, ...controller, '"referencePosition": u[0]')})
position = []
for row, reference in enumerate(u):
    controller.set({
        "referencePosition": reference,
        "position": plant["position"],
        "velocity": plant["velocity"],
    })
    plant["valveVoltage"] = controller["valveVoltage"]
${pushes}    position.append(plant["position"])
    plant.step(1e-3)
    controller.step(1e-3)
error = 1e3 * (u - np.array(position))
print(f"RMS error: {np.sqrt(np.mean(error**2)):.3f} mm")
plt.plot(t, 1e3 * u, "--", label="reference")
plt.plot(t, 1e3 * np.array(position), label="position")
${SHOWN}`;
}
