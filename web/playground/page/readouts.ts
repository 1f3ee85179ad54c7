// Numbers with their names and units.

import { element } from "./dom";

/** A row of numbers that change. */
export class Readouts {
  readonly root = element("dl", { class: "readouts" });
  private readonly values = new Map<string, HTMLElement>();

  constructor(names: readonly string[]) {
    for (const name of names) {
      const value = element("dd");
      this.values.set(name, value);
      this.root.append(element("div", {}, element("dt", {}, name), value));
    }
  }

  show(name: string, text: string): void {
    const value = this.values.get(name);
    if (value && value.textContent !== text) value.textContent = text;
  }
}
