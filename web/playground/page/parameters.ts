// All variables of the models of a page that a visitor may set, from the variable table.

import type { Context } from "./context";
import { element } from "./dom";
import { Refusal } from "./library";
import { Mistyped, quoting, typed } from "./typed";
import { plain, typedAs } from "./units";
import { displayUnit, group, isLive, isSettable, items, lawGroup, model, short, type Model, type Variable } from "./tables";

/** Words that the tables have for words of a search. */
const ALSO: Record<string, string[]> = {
  stiction: ["static friction"],
  "break-away": ["static friction"],
  "5/2": ["switching valve"],
  solenoid: ["switching valve"],
  pwm: ["pulse"],
  gravity: ["inclination", "incline"],
  cv: ["conductance"],
  kv: ["conductance"],
  backlash: ["hysteresis"],
  damping: ["viscous"],
  overlap: ["dead zone"],
  tube: ["hose"],
};

/** Takes over a value; throws a refusal. */
export type Change = (model: string, variable: Variable, value: number) => void;

export class Parameters {
  readonly root: HTMLElement;
  private readonly list = element("div", { class: "groups" });
  private readonly search = element("input", {
    type: "search",
    placeholder: "stiction, bar, Fs ...",
    "aria-label": "Search parameters",
    oninput: () => this.show(),
  });
  private hidden: readonly string[] = [];

  constructor(
    private readonly context: Context,
    private readonly change: Change,
    private readonly reset: () => void,
  ) {
    const defaults = element("button", { type: "button", onclick: () => this.reset() }, "All defaults");
    const bar = element("div", { class: "search" }, this.search, defaults);
    const summary = element("summary", {}, element("h2", {}, "Parameters"));
    this.root = element("details", { class: "card parameters", open: innerWidth > 900 }, summary, bar, this.list);
  }

  /** Shows the parameters of the present page, but not what the page itself sets. */
  show(hidden = this.hidden): void {
    this.hidden = hidden;
    const { settings, library } = this.context;
    const models = settings.models.map((name) => model(library.tables, name));
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const groups = models.flatMap((of) => this.groups(of, words));
    const none = element("p", { class: "muted" }, "No parameter has all of these words.");
    const focused = document.activeElement?.id;
    this.list.replaceChildren(...(groups.length ? groups : [none]));
    if (focused) document.getElementById(focused)?.focus();
  }

  /** Shows a value that was set elsewhere. */
  put(of: string, { name }: Variable, value: number): void {
    const field = document.getElementById(`${of}.${name}`);
    if (!(field instanceof HTMLInputElement || field instanceof HTMLSelectElement) || field === document.activeElement) return;
    if (field.type === "checkbox") (field as HTMLInputElement).checked = value !== 0;
    else field.value = String(value);
    field.closest(".row")?.classList.toggle("changed", this.context.settings.values[of].has(name));
  }

  /** The groups of a model; a group is what stands before the last dot of a name. */
  private groups(of: Model, words: string[]): HTMLElement[] {
    const groups = new Map<string, Variable[]>();
    for (const variable of of.variables) {
      if (!isSettable(variable) || this.hidden.includes(`${of.name}.${variable.name}`)) continue;
      const units = this.context.library.tables.units[variable.of ?? ""]?.display.map(({ name }) => name) ?? [];
      const text = [of.name, variable.name, variable.description, variable.of ?? "", ...units].join(" ").toLowerCase();
      if (!words.every((word) => [word, ...(ALSO[word] ?? [])].some((meant) => text.includes(meant)))) continue;
      const own = group(variable.name);
      groups.set(own, [...(groups.get(own) ?? []), variable]);
    }
    const choice = of.variables.find(({ name }) => name === "friction.law");
    const chosen = choice && (this.context.settings.values[of.name].get(choice.name) ?? choice.start);
    const law = lawGroup(of, chosen ?? 0);
    const order = [...groups].sort(([a], [b]) => Number(b === law) - Number(a === law));
    order.sort(([a], [b]) => Number(b === "friction") - Number(a === "friction"));
    return order.map(([name, variables]) => {
      const isOpen = words.length > 0 || name === law;
      const values = this.context.settings.values[of.name];
      const changed = variables.filter((variable) => values.has(variable.name)).length;
      const title = name === "" ? of.name : name;
      const badge = changed ? element("span", { class: "badge" }, `${changed} changed`) : null;
      const rows = variables.map((variable) => this.row(of, variable));
      return element("details", { open: isOpen }, element("summary", {}, title, badge), ...rows);
    });
  }

  private row(of: Model, variable: Variable): HTMLElement {
    const { settings, library } = this.context;
    const value = settings.values[of.name].get(variable.name) ?? variable.start ?? 0;
    const id = `${of.name}.${variable.name}`;
    const problem = element("p", { class: "problem", id: `${id}-problem`, role: "alert" });
    const isNumber = variable.kind === "Real" || variable.kind === "Integer";
    const unit = displayUnit(library.tables, variable);
    const shown = element("span", { class: "muted" });
    const tell = (number: number) => {
      const isOther = variable.kind === "Real" && unit.name !== variable.of && unit.name !== "";
      shown.textContent = isOther ? `= ${short(number * unit.factor + unit.offset, 5)} ${unit.name}` : "";
    };
    const take = (field: HTMLInputElement | HTMLSelectElement, read: () => number) => {
      try {
        const number = read();
        this.change(of.name, variable, number);
        problem.textContent = "";
        field.removeAttribute("aria-invalid");
        row.classList.toggle("changed", settings.values[of.name].has(variable.name));
        tell(number);
      } catch (error) {
        if (!(error instanceof Refusal || error instanceof Mistyped)) throw error;
        problem.textContent = error instanceof Refusal && isNumber ? quoting(field.value, error.message) : error.message;
        field.setAttribute("aria-invalid", "true");
      }
    };
    const field = this.field(variable, value, take);
    field.id = id;
    field.setAttribute("aria-describedby", `${id}-problem`);
    tell(value);
    const name = element("label", { for: id, class: "name" }, variable.name.slice(variable.name.lastIndexOf(".") + 1));
    const suffix = element("span", { class: "unit" }, variable.kind === "Real" && variable.of !== "1" ? variable.of : "");
    const input = element("div", { class: "field" }, field, suffix, shown);
    const text = element("p", { class: "muted" }, `${variable.description}. ${limits(variable)}.`);
    const isChanged = settings.values[of.name].has(variable.name);
    const row = element("div", { class: isChanged ? "row changed" : "row" }, name, input, text, problem);
    row.title = variable.name;
    return row;
  }

  private field(variable: Variable, value: number, take: (field: HTMLInputElement | HTMLSelectElement, read: () => number) => void): HTMLElement {
    if (variable.kind === "Enumeration") {
      const choices = items(this.context.library.tables, variable);
      const select = element("select", { onchange: () => take(select, () => Number(select.value)) });
      for (const item of choices) {
        select.append(element("option", { value: String(item.id), title: item.description }, item.name));
      }
      select.value = String(value);
      return select;
    }
    if (variable.kind === "Boolean") {
      const box = element("input", { type: "checkbox", onchange: () => take(box, () => Number(box.checked)) });
      box.checked = value !== 0;
      return box;
    }
    const { tables } = this.context.library;
    const si = { name: variable.of ?? "", factor: 1, offset: 0 };
    const units = variable.kind === "Real" ? typedAs(tables, si.name, si) : [];
    const text = element("input", {
      type: "text",
      inputmode: "decimal",
      autocomplete: "off",
      value: String(value),
      onchange: () => take(text, () => typed(text.value, si.name, units, (name) => plain(tables.spellings, name))),
    });
    return text;
  }
}

/** Range of a value, its default, and the time at which it takes effect. */
function limits(variable: Variable): string {
  const { min, max, start } = variable;
  const parts: string[] = [];
  if (variable.kind === "Real" || variable.kind === "Integer") {
    if (min !== null && max !== null) parts.push(`${short(min)} to ${short(max)}`);
    else if (min !== null) parts.push(`at least ${short(min)}`);
    if (start !== null) parts.push(`default ${short(start, 8)}`);
  }
  parts.push(isLive(variable) ? "takes effect at once" : "restarts the run");
  const text = parts.join("; ");
  return text[0].toUpperCase() + text.slice(1);
}
