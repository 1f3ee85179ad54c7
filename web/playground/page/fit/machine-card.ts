// Known values of the machine: those left out have their defaults, which affect the fit all the same.

import { element } from "../dom";
import { Refusal } from "../library";
import { model, variable, type Variable } from "../tables";
import type { FitContext } from "./study";
import { Mistyped, typed } from "../typed";
import { plain, typedAs, unitsOf } from "../units";

/** Own parameters of a machine. */
const OWN: [string, string][] = [
  ["supplyPressure", "Supply"],
  ["mass.moving", "Moving mass"],
  ["cylinder.bore", "Bore"],
  ["cylinder.rod", "Rod"],
  ["cylinder.stroke", "Stroke"],
  ["valve.C", "Conductance"],
];

/** Fields for what is known of a rig, without what is measured or estimated; nothing for a bench. */
export function machine(context: FitContext): HTMLElement | null {
  const { study, settings, library } = context;
  if (settings.experiment !== "rig") return null;
  const of = model(library.tables, study.modelName);
  const measured = new Set<string>(study.columns.keys());
  const asked = OWN.filter(([name]) => !measured.has(name) && !study.free.includes(name));
  const problem = element("p", { class: "problem", role: "alert" });
  const fields = asked.map(([name, label]) => field(context, variable(of, name), label, problem));
  const head = element("span", { class: "title" }, "What do you know of the machine?");
  return element("div", { role: "group", "aria-label": "Known of the machine" }, head, element("div", { class: "gains" }, ...fields), problem);
}

function field(context: FitContext, entry: Variable, label: string, problem: HTMLElement): HTMLElement {
  const { study, settings, library } = context;
  const units = unitsOf(library.tables, entry.of ?? "1");
  const unit = study.units.get(entry.name) ?? entry.display ?? entry.of ?? "1";
  const { factor, offset } = units.get(unit) ?? { factor: 1, offset: 0 };
  const given = settings.values[study.modelName].get(entry.name);
  const value = given ?? entry.start ?? 0;
  const input = element("input", {
    type: "text",
    inputmode: "decimal",
    "aria-label": label,
    value: String(Number(((value - offset) / factor).toPrecision(12))),
    onchange: () => {
      const shown = { name: unit, factor: 1 / factor, offset: -offset / factor };
      try {
        const number = typed(input.value, unit, typedAs(library.tables, entry.of ?? "1", shown), (name) => plain(library.tables.spellings, name));
        context.change(study.modelName, entry.name, factor * number + offset);
      } catch (error) {
        if (!(error instanceof Refusal || error instanceof Mistyped)) throw error;
        input.setAttribute("aria-invalid", "true");
        problem.textContent = `${label}: ${error.message}`;
      }
    },
  });
  const choice = element("select", {
    "aria-label": `Unit of ${label}`,
    onchange: () => {
      study.units.set(entry.name, choice.value);
      study.shown();
    },
  });
  for (const name of units.keys()) choice.append(element("option", { value: name }, name));
  choice.value = unit;
  const kind = given === undefined ? element("span", { class: "muted" }, "default") : "";
  return element("label", { class: "option", title: entry.description }, element("span", {}, label), input, choice, kind);
}
