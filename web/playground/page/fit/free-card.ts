// The card of estimated parameters, and of the use of the data.

import { element } from "../dom";
import { model, short } from "../tables";
import { Mistyped } from "../typed";
import { optionsOf, shownUnit, typedOption, type Option } from "./options";
import type { FitContext } from "./study";

/** Parameters that may be free, with those that usually are first; others are added by name. */
export function freeList(context: FitContext): HTMLElement {
  const { study, library } = context;
  const { usual, others: beside } = study.estimable;
  const names = [...usual, ...study.free.filter((name) => !usual.includes(name))];
  const boxes = names.map((name) => {
    const box = element("input", { type: "checkbox" });
    box.checked = study.free.includes(name);
    box.addEventListener("change", () => {
      study.setFree(name, box.checked);
      study.shown();
    });
    return element("label", { class: "free", title: describe(context, name) }, box, name);
  });
  const of = model(library.tables, study.modelName);
  const candidates = of.variables
    .filter(({ kind, role, name }) => kind === "Real" && (role === "fixed" || role === "tunable") && !names.includes(name))
    .map(({ name }) => name);
  const others = [...candidates, ...beside.filter((name) => !names.includes(name))];
  const list = element("datalist", { id: "free-names" }, ...others.map((value) => element("option", { value })));
  const problem = element("span", { class: "problem", role: "alert" });
  const input = element("input", {
    type: "text",
    list: "free-names",
    placeholder: "Estimate another: name",
    "aria-label": "Estimate another parameter",
    autocomplete: "off",
    onchange: () => {
      const name = input.value.trim();
      if (!name) return;
      if (others.includes(name)) {
        study.setFree(name, true);
        study.shown();
        document.querySelector<HTMLInputElement>("[aria-label='Estimate another parameter']")?.focus();
      } else if (!names.includes(name)) {
        problem.textContent = `${of.name} has no parameter ${name} that could be fitted`;
      }
    },
  });
  const group = element("div", { class: "frees", role: "group", "aria-label": "Estimated parameters" }, ...boxes);
  return element("div", {}, element("span", { class: "title" }, "Estimated parameters"), group, input, list, problem);
}

/** Description of a parameter, and the value at which the search starts if it was changed. */
function describe({ study, settings, library }: FitContext, name: string): string {
  const found = model(library.tables, study.modelName).variables.find((entry) => entry.name === name);
  const start = settings.values[study.modelName].get(name);
  if (!found) return name;
  return `${found.description}, in ${study.estimable.units[name] ?? found.of}${start === undefined ? "" : `; the search starts at ${short(start)}`}`;
}

/** Options of the use of the data. */
export function choices({ study, settings, library }: FitContext): HTMLElement {
  const { tables } = library;
  const problem = element("p", { class: "problem", role: "alert" });
  const take = (option: Option, input: HTMLInputElement | HTMLSelectElement) => {
    try {
      const value = typedOption(tables, option, input.value);
      if (value === null || value === option.usual) settings.options.delete(option.name);
      else settings.options.set(option.name, value);
      input.removeAttribute("aria-invalid");
      problem.textContent = "";
      study.context.changed();
    } catch (error) {
      if (!(error instanceof Mistyped)) throw error;
      input.setAttribute("aria-invalid", "true");
      problem.textContent = error.message;
    }
  };
  const fields = optionsOf(tables, settings.experiment).map((option) => {
    const { name, about, items, usual } = option;
    const value = settings.options.get(name) ?? usual;
    const { name: unit, factor } = shownUnit(tables, option);
    const attributes = { "aria-label": name, onchange: () => take(option, input) };
    const input: HTMLInputElement | HTMLSelectElement = items
      ? element("select", attributes, ...["", ...items].map((item) => element("option", { value: item }, item || "automatic")))
      : element("input", { type: "text", inputmode: "decimal", placeholder: usual === null ? "automatic" : "", ...attributes });
    input.value = typeof value === "number" ? String(Number((value / factor).toPrecision(12))) : (value ?? "");
    return element("label", { class: "option", title: about }, element("span", {}, name), input, element("span", { class: "unit" }, unit));
  });
  return element("details", { class: "options" }, element("summary", {}, "Options of the fit"), element("div", { class: "gains" }, ...fields), problem);
}
