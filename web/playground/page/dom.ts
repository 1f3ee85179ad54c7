// Short functions that make elements.

import { Refusal } from "./library";
import type { DisplayUnit } from "./tables";
import { Mistyped, quoting, typed } from "./typed";

/** By how much a number that is typed without its unit may be larger than the slider goes. */
const BEYOND = 10;

type Child = Node | string | null;

/** An element with attributes and children; attributes that start with `on` are listeners. */
export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, string | boolean | ((event: Event) => void)> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") made.addEventListener(name.slice(2), value);
    else if (typeof value === "boolean") made.toggleAttribute(name, value);
    else made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null));
  return made;
}

/** An element of a drawing. */
export function shape(tag: string, attributes: Record<string, string | number>, ...children: Node[]): SVGElement {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.append(...children);
  return made;
}

export function byId(id: string): HTMLElement {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element ${id}`);
  return found;
}

/**
 * A slider with its name, and its value and unit in a field, where values beyond the slider can be typed. The event `put`
 * with a value as its detail shows one that was set elsewhere.
 */
export function slider(options: {
  label: string;
  unit: string;
  /** Other units that may be typed, as they are to be turned into `unit`, and what gives one its own spelling. */
  others?: readonly DisplayUnit[];
  spelled?: (name: string) => string;
  min: number;
  max: number;
  step: number;
  value: number;
  title?: string;
  /** Whether only values above 0 make sense. */
  isPositive?: boolean;
  /** The number that is shown for a place of the slider, and its inverse, if it is not the place itself. */
  scale?: { shown: (place: number) => number; place: (shown: number) => number };
  /** Takes over a value; throws a refusal. */
  onChange: (value: number) => void;
}): HTMLElement {
  const { shown, place } = options.scale ?? { shown: (same: number) => same, place: (same: number) => same };
  const ends = [shown(options.min), shown(options.max)].map((end) => Number(end.toPrecision(4)));
  const plausible = { largest: BEYOND * Math.max(...ends.map(Math.abs)), range: `${ends[0]} to ${ends[1]} ${options.unit}` };
  const problem = element("p", { class: "problem", role: "alert", hidden: true });
  const put = (value: number): void => {
    input.value = String(value);
    field.value = `${Number(shown(value).toPrecision(6))} ${options.unit}`.trim();
    input.setAttribute("aria-valuetext", field.value);
    tell("");
  };
  const tell = (text: string): void => {
    problem.textContent = text;
    problem.hidden = text === "";
    field.setAttribute("aria-invalid", String(text !== ""));
  };
  const take = (read: () => number, text?: string): void => {
    try {
      const value = read();
      options.onChange(value);
      put(value);
    } catch (error) {
      if (!(error instanceof Mistyped || error instanceof Refusal)) throw error;
      tell(text !== undefined && error instanceof Refusal ? quoting(text, error.message) : error.message);
    }
  };
  const field = element("input", {
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    "aria-label": `${options.label}, value`,
    onchange: () =>
      take(() => {
        const number = typed(field.value, options.unit, options.others ?? [], options.spelled, plausible);
        if (options.isPositive && number <= 0) throw new Mistyped(`“${field.value.trim()}” is not positive`);
        return place(number);
      }, field.value),
  });
  const input = element("input", {
    type: "range",
    min: String(options.min),
    max: String(options.max),
    step: String(options.step),
    "aria-label": options.label,
    oninput: () => take(() => input.valueAsNumber),
  });
  put(options.value);
  const attributes = { class: "slider", ...(options.title ? { title: options.title } : {}) };
  const root = element("div", attributes, element("span", {}, options.label), input, field, problem);
  root.addEventListener("put", (event) => put((event as CustomEvent<number>).detail));
  return root;
}

/** A choice among names. */
export function choice<T extends string | number>(
  label: string,
  options: readonly (readonly [T, string])[],
  value: T,
  onChange: (value: T) => void,
): HTMLElement {
  const select = element("select", {
    "aria-label": label,
    onchange: () => onChange(options[select.selectedIndex][0]),
  });
  for (const [item, name] of options) select.append(element("option", { value: String(item) }, name));
  select.value = String(value);
  return element("label", { class: "choice" }, element("span", {}, label), select);
}

/** Choices of which one is pressed. */
export function segments<T extends string | number>(
  label: string,
  options: readonly (readonly [T, string])[],
  value: T,
  onChange: (value: T) => void,
): HTMLElement {
  const group = element("div", { class: "segments", role: "group", "aria-label": label });
  for (const [item, name] of options) {
    const button = element("button", { type: "button", "aria-pressed": String(item === value) }, name);
    button.addEventListener("click", () => {
      for (const other of group.children) other.setAttribute("aria-pressed", String(other === button));
      onChange(item);
    });
    group.append(button);
  }
  return group;
}
