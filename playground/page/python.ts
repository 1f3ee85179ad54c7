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

const IMPORTS = "import numpy as np\nimport pneumatic_servo as ps\n\n";

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
  input: { variable: string; signal: Signal },
  rows: number,
  csv: string,
): string {
  const from = isFormula(input.signal) ? "" : `  # as many rows as ${csv} has`;
  const lines = [
    `t = np.arange(${rows}) * 1e-3${from}\n`,
    isFormula(input.signal) ? formula(input.signal) : table(csv),
    `plant = ps.Model(${JSON.stringify(name)})\n`,
    ...runs.map(
      ([variable, values, prefix]) =>
        `${variable} = plant.simulate(${dictionary(tables, name, values)}, ` +
        `inputs={${JSON.stringify(input.variable)}: (t, ${isFormula(input.signal) ? "u" : column(prefix + input.variable)})}, stop=t[-1], step=1e-3)\n`,
    ),
  ];
  return IMPORTS + lines.join("");
}

/** The closed loop, stepped as a host does it: each gets what the other shows at the same instant. */
export function closedLoop(
  tables: Tables,
  cylinder: readonly [string, ReadonlyMap<string, number>],
  controller: readonly [string, ReadonlyMap<string, number>],
  signal: Signal,
  rows: number,
  csv: string,
): string {
  return `${IMPORTS}t = np.arange(${rows}) * 1e-3
${isFormula(signal) ? formula(signal) : `${table(csv)}u = ${column("controller.referencePosition")}\n`}plant = ps.Model(${JSON.stringify(cylinder[0])}).start(${dictionary(tables, ...cylinder)})
controller = ps.Model(${JSON.stringify(controller[0])}).start(${dictionary(tables, ...controller, '"referencePosition": u[0]')})
position = []
for reference in u:
    controller.set({
        "referencePosition": reference,
        "position": plant["position"],
        "velocity": plant["velocity"],
    })
    plant["valveVoltage"] = controller["valveVoltage"]
    position.append(plant["position"])
    plant.step(1e-3)
    controller.step(1e-3)
`;
}
