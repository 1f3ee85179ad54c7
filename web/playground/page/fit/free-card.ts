// The card of estimated parameters, and of the use of the data.

import { element } from "../dom";
import { experiment, model, short } from "../tables";
import type { Choices, FitContext } from "./study";

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
  return `${found.description}, in ${found.of}${start === undefined ? "" : `; the search starts at ${short(start)}`}`;
}

interface Entry {
  key: keyof Choices;
  label: string;
  unit: string;
  /** The number in SI units is the shown one times this. */
  factor: number;
  title: string;
  least: number;
  below: number;
}

const ENTRIES: Entry[] = [
  { key: "validation", label: "Validation", unit: "%", factor: 1e-2, title: "Share of the record at its end that is predicted, not fitted", least: 0, below: 100 },
  { key: "starts", label: "Random starts", unit: "", factor: 1, title: "Used where the start from the data leaves more than noise", least: 0, below: 1001 },
  { key: "width", label: "Smoothing", unit: "ms", factor: 1e-3, title: "Width of the parabolas that give velocities", least: 1e-3, below: 1e5 },
  { key: "rated", label: "Rated load", unit: "N", factor: 1, title: "Normal force at which the load factor is 1", least: 1e-9, below: 1e12 },
  { key: "play", label: "Play", unit: "um", factor: 1e-6, title: "Hides the jitter of a position at rest; empty: three times its noise", least: 0, below: 1e9 },
];

/** Options of the use of the data. */
export function choices({ study, settings, library }: FitContext): HTMLElement {
  const { options } = experiment(library.tables, settings.experiment);
  const isShown = ({ key }: Entry) => key === "validation" || key === "starts" || options.includes(key);
  const fields = ENTRIES.filter(isShown).map((entry) => {
    const { key, label, unit, factor, title, least, below } = entry;
    const value = study.choices[key];
    const input = element("input", {
      type: "text",
      inputmode: "decimal",
      "aria-label": label,
      value: value === null ? "" : String(Number((value / factor).toPrecision(12))),
      onchange: () => {
        const text = input.value.trim();
        const isEmpty = text === "" && key === "play";
        const number = text === "" ? NaN : Number(text);
        const isWhole = key !== "starts" || Number.isInteger(number);
        const isFine = isEmpty || (number >= least && number < below && isWhole);
        input.toggleAttribute("aria-invalid", false);
        if (!isFine) {
          input.setAttribute("aria-invalid", "true");
          problem.textContent = `${label} = ${text} ${unit} is refused: it must be at least ${least} and below ${below}${key === "starts" ? ", and whole" : ""}`;
          return;
        }
        problem.textContent = "";
        Object.assign(study.choices, { [key]: isEmpty ? null : number * factor });
      },
    });
    return element("label", { class: "option", title }, element("span", {}, label), input, element("span", { class: "unit" }, unit));
  });
  const problem = element("p", { class: "problem", role: "alert" });
  return element("details", { class: "options" }, element("summary", {}, "Options of the fit"), element("div", { class: "gains" }, ...fields), problem);
}
