// Downloads of a fit: the curves, the fitted set for the FMU, and a program that repeats it.

import type { Files } from "../context";
import { dictionary } from "../python";
import { lawName, model } from "../tables";
import type { FitContext, Found } from "./study";
import { rangesOf } from "./table";

export function filesOf(context: FitContext, found: Found): Omit<Files, "charts"> {
  const { library, study } = context;
  const { question } = found;
  const base = question.file.replace(/\.[^.]*$/, "");
  return {
    name: `${base}-fitted`,
    // Made when they are asked for: the table may be long.
    get csv() {
      return curves(found);
    },
    get ssv() {
      const values = fittedValues(context, found);
      const about = [`Fitted parameters of ${study.modelName}`, found.answer.unitsTold].filter(Boolean);
      return library.ssv(`${base}-fitted`, about.join(", "), [{ model: study.modelName, prefix: "", values }], new Date());
    },
    get python() {
      return program(context, found, `${base}-fitted`);
    },
  };
}

/** Values with which the model repeats a fit: the state at its start, what was known, and what was found. */
export function fittedValues({ library, study }: FitContext, { question, answer }: Found): Map<string, number> {
  const names = new Set(library.tables.models.find(({ name }) => name === study.modelName)?.variables.map(({ name }) => name));
  const fitted = answer.estimates.map(({ name, value }) => [name, value] as const).filter(([name]) => names.has(name));
  const start = [...answer.start].filter(([name]) => names.has(name));
  const known = [...question.known].filter(([name]) => names.has(name));
  return new Map([...start, ["friction.law", question.law], ...known, ...fitted]);
}

/** Measured and simulated values in SI units. */
function curves({ question, answer }: Found): string {
  const signals = [...answer.rms.keys()];
  const lines = [[question.signals.has("time") ? "time" : "velocity", ...signals.flatMap((signal) => [`measured.${signal}`, `simulated.${signal}`])].join(",")];
  for (const { across, measured, simulated } of answer.courses) {
    const columns = [across, ...signals.flatMap((signal) => [measured.get(signal)!, simulated.get(signal)!])];
    for (let row = 0; row < across.length; row += 1) lines.push(columns.map((column) => String(column[row])).join(","));
  }
  return `${lines.join("\n")}\n`;
}

/** Rising numbers as ranges of Python, each without its end. */
const ranges = (numbers: readonly number[]): string => rangesOf(numbers).map(([first, last]) => `${first}:${last + 1}`).join(", ");

/** An option in Python. */
const literal = (value: number | string): string => (typeof value === "number" ? String(value) : ({ on: "True", off: "False" }[value] ?? JSON.stringify(value)));

/** A program for the Python package that makes the same fit. */
function program({ library, study }: FitContext, { question, columns, table, leftOut }: Found, name: string): string {
  const { known, free, options } = question;
  const fixed = [...known].filter(([key]) => !free.includes(key));
  const names = new Set(model(library.tables, study.modelName).variables.map((variable) => variable.name));
  const ofModel = new Map(fixed.filter(([key]) => names.has(key)));
  const ofSensors = fixed.filter(([key]) => !names.has(key)).map(([key, value]) => `${JSON.stringify(key)}: ${value}`);
  const column = ([signal, { place, unit, turned }]: [string, { place: number; unit: string; turned: boolean }]) =>
    `    ${JSON.stringify(signal)}: ${JSON.stringify(`${turned ? "-" : ""}${table.names[place]}[${unit}]`)},\n`;
  const start = (key: string) => JSON.stringify(known.has(key) ? `${key}=${known.get(key)}` : key);
  const further = [
    `validation=${question.validation}`,
    `starts=${question.starts}`,
    ...Object.entries(options).map(([name, value]) => `${name}=${literal(value)}`),
  ];
  const file = JSON.stringify(question.file);
  const [imports, reading, data] = leftOut.length
    ? [
        "import numpy as np\nimport pneumatic_servo as ps\nfrom pneumatic_servo.tables import read_table",
        `table = read_table(${file})\nkept = ~np.isin(table.lines, np.r_[${ranges(leftOut)}])\ndata = dict(zip(table.names, table.values[kept].T))\n`,
        "data",
      ]
    : ["import pneumatic_servo as ps", "", file];
  return `${imports}

${reading}columns = {
${[...columns].map(column).join("")}}
found = ps.fit(
    ${data},
    experiment=${JSON.stringify(question.experiment)},
    law=${JSON.stringify(lawName(library.tables, question.law))},
    fit=[${free.map(start).join(", ")}],
    columns=columns,
    settings=${dictionary(library.tables, study.modelName, ofModel, ...ofSensors).replaceAll("\n", "\n    ")},
    ${further.join(", ")},
)
print(found)
found.to_ssv(${JSON.stringify(`${name}.ssv`)})
`;
}
