// Sliders of parameters, each in its customary unit.

import type { Context } from "./context";
import { element, slider } from "./dom";
import { CYLINDER } from "./settings";
import { plain, typedAs } from "./units";
import { displayUnit, lawGroup, model, variable } from "./tables";

/** A slider of a parameter, whose ends are in SI units. */
export function parameterSlider(context: Context, of: string, name: string, label: string, [min, max]: [number, number]): HTMLElement {
  const { tables } = context.library;
  const { settings } = context;
  const entry = variable(model(tables, of), name);
  const { name: unit, factor, offset } = displayUnit(tables, entry);
  const made = slider({
    label,
    unit,
    others: typedAs(tables, entry.of ?? "", { name: unit, factor, offset }),
    spelled: (name) => plain(tables.spellings, name),
    title: `${name}: ${entry.description}`,
    min,
    max,
    step: Number(((max - min) / 200).toPrecision(1)),
    scale: { shown: (si) => si * factor + offset, place: (shown) => Number(((shown - offset) / factor).toPrecision(12)) },
    value: settings.values[of].get(name) ?? entry.start ?? 0,
    onChange: (value) => context.change(of, name, value),
  });
  made.dataset.parameter = `${of}.${name}`;
  return made;
}

/** Main parameters of a cylinder's motion, with the ends of their sliders in SI units. */
const PLANT: readonly (readonly [string, string, [number, number]])[] = [
  ["supplyPressure", "Supply", [1.5e5, 1e6]],
  ["mass.moving", "Moving mass", [0.8, 5]],
  ["externalForce", "External force", [-30, 30]],
  ["valve.deadZone", "Dead zone", [0, 0.3]],
];
/** Parameters of a friction law, under the names that laws have for them. */
const FRICTION: readonly (readonly [readonly string[], string, [number, number]])[] = [
  [["Fs"], "Static friction", [0, 30]],
  [["Fc", "Fc1"], "Coulomb friction", [0, 30]],
  [["sigma2", "c1"], "Viscous friction", [0, 150]],
];

/** The sliders that matter most for a model under its present law. */
export class Essentials {
  readonly root = element("div", { class: "essentials" });

  constructor(
    private readonly context: Context,
    private readonly of: string,
  ) {
    this.show();
  }

  /** Shows the sliders anew, under a law that was chosen. */
  show(): void {
    const { settings, library } = this.context;
    const of = model(library.tables, this.of);
    const law = settings.values[this.of].get("friction.law") ?? variable(of, "friction.law").start ?? 0;
    const group = lawGroup(of, law);
    const has = (name: string) => of.variables.some((candidate) => candidate.name === name);
    const friction = FRICTION.flatMap(([names, label, ends]) => {
      const name = names.map((own) => `${group}.${own}`).find(has);
      return name && group ? [[name, label, ends] as const] : [];
    });
    const all = [...(this.of === CYLINDER ? PLANT : []), ...friction];
    this.root.replaceChildren(...all.map(([name, label, ends]) => parameterSlider(this.context, this.of, name, label, ends)));
  }
}
