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

/** An input over the times `t`: a formula, or else a column of the downloaded file, which has the drawing and the slider. */
function course(signal: Signal, csv: string, column: string): string {
  if (isFormula(signal)) {
    const { level, amplitude, period } = signal;
    return `u = ${level} + ${amplitude} * np.sin(2 * np.pi * t / ${period})\n`;
  }
  return `u = np.genfromtxt("${csv}", delimiter=",", names=True, deletechars="")["${column}"]\n`;
}

/** One model with one input. */
export function oneModel(
  tables: Tables,
  name: string,
  runs: readonly (readonly [string, ReadonlyMap<string, number>])[],
  input: { variable: string; column: string; signal: Signal },
  rows: number,
  csv: string,
): string {
  const from = isFormula(input.signal) ? "" : `  # as many rows as ${csv} has`;
  const lines = [
    `t = np.arange(${rows}) * 1e-3${from}\n`,
    course(input.signal, csv, input.column),
    `plant = ps.Model(${JSON.stringify(name)})\n`,
    ...runs.map(
      ([variable, values]) =>
        `${variable} = plant.simulate(${dictionary(tables, name, values)}, ` +
        `inputs={${JSON.stringify(input.variable)}: (t, u)}, stop=t[-1], step=1e-3)\n`,
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
${course(signal, csv, "controller.referencePosition")}plant = ps.Model(${JSON.stringify(cylinder[0])}).start(${dictionary(tables, ...cylinder)})
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
