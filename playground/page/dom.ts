// Elements, made shortly.

import { Refusal } from "./library";
import { Mistyped, typed } from "./typed";

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

/** A slider with its name, and its value and unit in a field, where values beyond the slider can be typed. */
export function slider(options: {
  label: string;
  unit: string;
  min: number;
  max: number;
  step: number;
  value: number;
  title?: string;
  /** The number that is shown for a place of the slider, and its inverse, if it is not the place itself. */
  scale?: { shown: (place: number) => number; place: (shown: number) => number };
  /** Takes over a value; throws a refusal. */
  onChange: (value: number) => void;
}): HTMLElement {
  const { shown, place } = options.scale ?? { shown: (same: number) => same, place: (same: number) => same };
  const text = (value: number) => `${Number(shown(value).toPrecision(6))} ${options.unit}`.trim();
  const take = (value: number): void => {
    options.onChange(value);
    field.value = text(value);
    input.setAttribute("aria-valuetext", field.value);
  };
  const field = element("input", {
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    "aria-label": `${options.label}, value`,
    onchange: () => {
      let problem = "";
      try {
        const number = typed(field.value, options.unit, []);
        if ((options.min > 0 || options.scale) && number <= 0) throw new Mistyped(`“${field.value.trim()}” is not positive`);
        const value = place(number);
        take(value);
        input.value = String(value);
      } catch (error) {
        if (!(error instanceof Mistyped || error instanceof Refusal)) throw error;
        problem = error.message;
      }
      field.setCustomValidity(problem);
      field.setAttribute("aria-invalid", String(problem !== ""));
      field.reportValidity();
    },
  });
  field.value = text(options.value);
  const input = element("input", {
    type: "range",
    min: String(options.min),
    max: String(options.max),
    step: String(options.step),
    "aria-label": options.label,
    "aria-valuetext": text(options.value),
    oninput: () => take(input.valueAsNumber),
  });
  input.value = String(options.value);
  const attributes = { class: "slider", ...(options.title ? { title: options.title } : {}) };
  return element("div", attributes, element("span", {}, options.label), input, field);
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
