// The choice of a friction law.

import type { Context } from "./context";
import { choice } from "./dom";
import { laws, model, variable } from "./tables";

const options = (context: Context) =>
  laws(context.library.tables).map((law) => [law.id, `${law.name}: ${law.description}`] as const);

/** The choice of a model's law. */
export function lawChoice(context: Context, of: string, label: string): HTMLElement {
  const start = variable(model(context.library.tables, of), "friction.law").start ?? 0;
  const present = context.settings.values[of].get("friction.law") ?? start;
  const made = choice(label, options(context), present, (law) => context.change(of, "friction.law", law));
  made.querySelector("select")?.setAttribute("data-of", `${of}.friction.law`);
  return made;
}

/** The choice of a law to compare with. */
export function secondLawChoice(context: Context, choose: (law: number) => void): HTMLElement {
  return choice("Second law", options(context), context.settings.secondLaw, choose);
}
