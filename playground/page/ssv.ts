// Parameter values in the form of the standard SSP 1.0, which hosts of the FMU read.

import { items, model, variable, type Tables, type Variable } from "./tables";

/** Values of a model, and what stands before their names. */
export interface Part {
  model: string;
  prefix: string;
  values: ReadonlyMap<string, number>;
}

const COMMON = "http://ssp-standard.org/SSP1/SystemStructureCommon";
const VALUES = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
const BASE = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

const escaped = (text: string): string =>
  text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll('"', "&quot;");

/** The file. A number is written so that reading it gives the same bits. */
export function ssv(tables: Tables, name: string, description: string, parts: readonly Part[], now: Date): string {
  const units = new Set<string>();
  const lines = parts.flatMap((part) =>
    [...part.values].map(([key, value]) => {
      const of = variable(model(tables, part.model), key);
      if (of.kind === "Real" && of.of) units.add(of.of);
      const full = escaped(part.prefix + key);
      return `    <ssv:Parameter name="${full}">\n      ${typed(tables, of, value)}\n    </ssv:Parameter>`;
    }),
  );
  const root = [
    `<ssv:ParameterSet xmlns:ssc="${COMMON}" xmlns:ssv="${VALUES}" version="1.0" name="${escaped(name)}"`,
    `description="${escaped(description)}" generationTool="pneumatic-servo-playground ${tables.version}"`,
    `generationDateAndTime="${now.toISOString().replace(/\.\d+/, "")}">`,
  ].join(" ");
  const parameters = ["  <ssv:Parameters>", ...lines, "  </ssv:Parameters>"];
  const body = [root, ...parameters, ...unitLines(tables, [...units]), "</ssv:ParameterSet>"];
  return `<?xml version="1.0" encoding="UTF-8"?>\n${body.join("\n")}\n`;
}

function typed(tables: Tables, of: Variable, value: number): string {
  switch (of.kind) {
    case "Real":
      return `<ssv:Real value="${value}" unit="${escaped(of.of ?? "")}"/>`;
    case "Integer":
      return `<ssv:Integer value="${value}"/>`;
    case "Boolean":
      return `<ssv:Boolean value="${value !== 0}"/>`;
    case "Enumeration":
      return `<ssv:Enumeration value="${items(tables, of).find((item) => item.id === value)?.name ?? ""}"/>`;
  }
}

function unitLines(tables: Tables, names: string[]): string[] {
  if (names.length === 0) return [];
  const lines = names.map((name) => {
    const base = tables.units[name].base.flatMap((power, index) => (power ? [` ${BASE[index]}="${power}"`] : []));
    return `    <ssc:Unit name="${escaped(name)}">\n      <ssc:BaseUnit${base.join("")}/>\n    </ssc:Unit>`;
  });
  return ["  <ssv:Units>", ...lines, "  </ssv:Units>"];
}
