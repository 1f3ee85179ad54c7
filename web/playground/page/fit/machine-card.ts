// Known values of the machine: those left out have their defaults, which affect the fit all the same.

import { element } from "../dom";
import { Refusal } from "../library";
import { experiment, model } from "../tables";
import type { FitContext } from "./study";
import { Mistyped, typed } from "../typed";
import { plain, typedAs, unitsOf } from "../units";

/** Fields for what is known of a machine or a bench, without what is measured or estimated; nothing where nothing can be known. */
export function machine(context: FitContext): HTMLElement | null {
  const { study, settings, library } = context;
  const { machine: own } = experiment(library.tables, settings.experiment);
  const { bench } = study.estimable;
  const asked = [...new Set([...own, ...Object.keys(bench)])].filter((name) => !study.columns.has(name) && !study.free.includes(name));
  if (!asked.length) return null;
  const problem = element("p", { class: "problem", role: "alert" });
  const fields = asked.map((name) => field(context, name, bench[name], problem));
  const head = element("span", { class: "title" }, "What do you know of the machine?");
  return element("div", { role: "group", "aria-label": "Known of the machine" }, head, element("div", { class: "gains" }, ...fields), problem);
}

/** A field for a parameter; one with a unit of a bench has no default. */
function field(context: FitContext, name: string, ofBench: string | undefined, problem: HTMLElement): HTMLElement {
  const { study, settings, library } = context;
  const { tables } = library;
  const entry = model(tables, study.modelName).variables.find((variable) => variable.name === name);
  const si = ofBench ?? entry?.of ?? "1";
  const units = unitsOf(tables, si);
  const unit = [study.units.get(name), entry?.display].find((known) => known && units.has(known)) ?? si;
  const { factor, offset } = units.get(unit) ?? { factor: 1, offset: 0 };
  const given = settings.beside.get(name) ?? settings.values[study.modelName].get(name);
  const value = given ?? (ofBench === undefined ? entry?.start : null) ?? null;
  const input = element("input", {
    type: "text",
    inputmode: "decimal",
    "aria-label": name,
    value: value === null ? "" : String(Number(((value - offset) / factor).toPrecision(12))),
    onchange: () => {
      const shown = { name: unit, factor: 1 / factor, offset: -offset / factor };
      try {
        if (ofBench !== undefined) settings.beside.delete(name);
        if (ofBench === undefined || input.value.trim() !== "") {
          const number = factor * typed(input.value, unit, typedAs(tables, si, shown), (other) => plain(tables.spellings, other)) + offset;
          if (ofBench === undefined) context.change(study.modelName, name, number);
          else settings.beside.set(name, number);
        }
        if (ofBench !== undefined) study.changed();
      } catch (error) {
        if (!(error instanceof Refusal || error instanceof Mistyped)) throw error;
        input.setAttribute("aria-invalid", "true");
        problem.textContent = `${name}: ${error.message}`;
      }
    },
  });
  const choice = element("select", {
    "aria-label": `Unit of ${name}`,
    onchange: () => {
      study.units.set(name, choice.value);
      study.shown();
    },
  });
  for (const other of units.keys()) choice.append(element("option", { value: other }, other));
  choice.value = unit;
  const kind = given === undefined ? element("span", { class: "muted" }, value === null ? "not given" : "default") : "";
  return element("label", { class: "option", title: entry?.description ?? name }, element("span", {}, name), input, choice, kind);
}
