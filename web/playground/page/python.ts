// Snippets for the Python package that repeat a run.

import { DITHER_STEPS } from "./position-loop";
import type { Run } from "./run";
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

/** The part of a run that a program repeats. */
export interface Course extends Pick<Run, "changes" | "isPushed" | "isRedirected"> {
  members: readonly Pick<Run["members"][number], "model" | "values" | "prefix">[];
}

const SHOWN = 'plt.xlabel("time (s)"), plt.ylabel("position (mm)"), plt.legend(), plt.show()\n';

/** Reads the file of the run; spaces in the names of its columns stay. */
const begin = (csv: string): string => `import matplotlib.pyplot as plt
import numpy as np
import pneumatic_servo as ps

table = np.genfromtxt("${csv}", delimiter=",", names=True, deletechars="", replace_space=" ")
t = table["time"]
`;
/** The sizes of the steps, which lead to the very times of the page; the last one leads beyond the file. */
const SIZES = "sizes = np.diff(t, append=t[-1] + 1e-3)\n";
const column = (name: string): string => `table[${JSON.stringify(name)}]`;

/** The formula of an input, for experiments of one's own: the file has what the page gave, to the last bit. */
const formula = (variable: string, signal: Signal | null, { isRedirected }: Course): string =>
  signal && isFormula(signal) && !isRedirected
    ? `# ${variable} is, but for the last bits: ${signal.level} + ${signal.amplitude} * np.sin(2 * np.pi * t / ${signal.period})\n`
    : "";

/** A dictionary, under a name, of the values of a model that were changed after a row, by this row; nothing if there are none. */
function changed(tables: Tables, name: string, { changes }: Course, model: string): string {
  const rows = new Map<number, Map<string, number>>();
  for (const change of changes) {
    if (change.model === model) rows.set(change.row, new Map(rows.get(change.row)).set(change.name, change.value));
  }
  const lines = [...rows].map(([row, values]) => `    ${row}: ${dictionary(tables, model, values).replaceAll("\n", "\n    ")},\n`);
  return lines.length ? `# Changed under way, after these rows.\n${name} = {\n${lines.join("")}}\n` : "";
}

/** Says how far a course of positions is from that of the file. */
const compared = (label: string, position: string, name: string): string =>
  `print(f"${label}: {1e3 * ${position}[-1]:.3f} mm at {t[-1]:.3f} s; " +\n` +
  `      f"at most {1e3 * abs(${position} - ${column(name).replaceAll('"', "'")}).max():g} mm from the file")\n`;

/**
 * Runs of one model, whose input is a column of the file of the run. `names`: of the runs in the program. A run in which
 * something was changed is stepped.
 */
export function oneModel(
  tables: Tables,
  course: Course,
  names: readonly string[],
  input: string,
  signal: Signal | null,
  csv: string,
): string {
  const { members, isPushed } = course;
  const { model } = members[0];
  const inputs = isPushed ? [input, "externalForce"] : [input];
  const changes = changed(tables, "changes", course, model);
  const simulated = (name: string, { values, prefix }: Course["members"][number]) => {
    const lines = inputs.map((variable) => `${JSON.stringify(variable)}: (t, ${column(prefix + variable)})`);
    return (
      `${name} = plant.simulate(${dictionary(tables, model, values)}, ` +
      `inputs={${lines.join(", ")}}, stop=t[-1], step=1e-3)\n`
    );
  };
  const stepped = (name: string, { values, prefix }: Course["members"][number]) =>
    `${name} = stepped(${dictionary(tables, model, values)}, ${JSON.stringify(prefix)})\n`;
  const function_ = `${SIZES}${changes}
def stepped(values, prefix):
    run = plant.start({**values, ${JSON.stringify(input)}: table[prefix + ${JSON.stringify(input)}][0]})
    position = []
    for row, size in enumerate(sizes):
${inputs.map((variable) => `        run[${JSON.stringify(variable)}] = table[prefix + ${JSON.stringify(variable)}][row]\n`).join("")}\
        position.append(run["position"])
        run.set(changes.get(row, {}))
        run.step(size)
    return {"position": np.array(position)}

`;
  const run = changes ? stepped : simulated;
  return [
    begin(csv),
    formula(input, signal, course),
    `plant = ps.Model(${JSON.stringify(model)})\n`,
    changes && function_,
    ...names.map((name, index) => run(name, members[index])),
    ...names.map((name, index) => compared(name, `${name}['position']`, `${members[index].prefix}position`)),
    ...names.map((name) => `plt.plot(t, 1e3 * ${name}["position"], label="${name}")\n`),
    SHOWN,
  ].join("");
}

/** The closed loop, stepped as a host does it: each gets what the other shows at the same instant. */
export function closedLoop(tables: Tables, course: Course, signal: Signal, csv: string, dither: number): string {
  const [plant, controller] = course.members;
  const parts = [["plant", plant] as const, ["controller", controller] as const];
  const changes = parts.map(([name, { model }]) => [name, changed(tables, `${name}_changes`, course, model)] as const);
  const pushes = course.isPushed ? `    plant["externalForce"] = table["plant.externalForce"][row]\n` : "";
  const sets = changes.map(([name, text]) => (text ? `    ${name}.set(${name}_changes.get(row, {}))\n` : ""));
  const dithered = dither === 0 ? "" : ` + (${dither} if row // ${DITHER_STEPS} % 2 == 0 else -${dither})`;
  const reference = "controller.referencePosition";
  return `${begin(csv)}${formula(reference, signal, course)}u = ${column(reference)}
${SIZES}${changes.map(([, text]) => text).join("")}\
plant = ps.Model(${JSON.stringify(plant.model)}).start(${dictionary(tables, plant.model, plant.values)})
controller = ps.Model(${JSON.stringify(controller.model)}).start(${dictionary(tables, controller.model, controller.values, '"referencePosition": u[0]')})
position = []
for row, (reference, size) in enumerate(zip(u, sizes)):
    controller.set({
        "referencePosition": reference,
        "position": plant["position"],
        "velocity": plant["velocity"],
    })
    plant["valveVoltage"] = controller["valveVoltage"]${dithered}
${pushes}    position.append(plant["position"])
${sets.join("")}\
    plant.step(size)
    controller.step(size)
position = np.array(position)
error = 1e3 * (u - position)
print(f"RMS error: {np.sqrt(np.mean(error**2)):.3f} mm")
${compared("position", "position", "plant.position")}\
plt.plot(t, 1e3 * u, "--", label="reference")
plt.plot(t, 1e3 * position, label="position")
${SHOWN}`;
}
