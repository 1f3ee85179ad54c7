// Options of a fit: which there are, and what may be given for them.

import { experiment, type FitOption, type Tables } from "../tables";
import { Mistyped, typed } from "../typed";
import { plain, typedAs, unitsOf } from "../units";

/** An option with further limits. */
export interface Option extends FitOption {
  below?: number;
  isWhole?: boolean;
}

/** Chosen options by name: numbers in SI units, and items. Others have their defaults. */
export type Options = Map<string, number | string>;

/** Options of every experiment, beside those of the library. */
const OF_ALL: Option[] = [
  { name: "validation", about: "Share of the record at its end that is predicted, not fitted", usual: 0.3, unit: "%", si: "1", isPositive: false, items: null, below: 1 },
  { name: "starts", about: "Random starts, used where the start from the data leaves more than noise", usual: 8, unit: null, si: null, isPositive: false, items: null, below: 1001, isWhole: true },
];

export const optionsOf = (tables: Tables, name: string): Option[] => [...OF_ALL, ...experiment(tables, name).options];

/** How a number is shown: in its unit. */
export function shownUnit(tables: Tables, { si, unit }: Option): { name: string; factor: number } {
  const { factor } = (si !== null && unitsOf(tables, si).get(unit ?? "")) || { factor: 1 };
  return { name: unit ?? "", factor };
}

/** The value of a typed text; null where it is empty. Throws `Mistyped`, which names the option. */
export function typedOption(tables: Tables, option: Option, text: string): number | string | null {
  const { name, si, items } = option;
  if (text.trim() === "") return null;
  if (items) return checked(option, text.trim(), text);
  const shown = shownUnit(tables, option);
  const { name: unit, factor } = shown;
  const others = si === null ? [] : typedAs(tables, si, { name: unit, factor: 1 / factor, offset: 0 });
  try {
    return checked(option, factor * typed(text, unit, others, (other) => plain(tables.spellings, other)), text, shown);
  } catch (error) {
    if (error instanceof Mistyped && !error.message.startsWith(name)) throw new Mistyped(`${name}: ${error.message}`);
    throw error;
  }
}

/** A value in SI units, or an item, as a link has it. Throws `Mistyped`, which names the option. */
export const linkedOption = (option: Option, text: string): number | string => checked(option, option.items ? text : text.trim() === "" ? NaN : Number(text), text);

function checked({ name, items, isPositive, below, isWhole }: Option, value: number | string, text: string, shown = { name: "", factor: 1 }): number | string {
  const refused = (why: string) => new Mistyped(`${name} = ${text.trim()} is refused: it must be ${why}`);
  if (typeof value === "string" || items) {
    if (items?.includes(String(value))) return value;
    throw refused(`${items?.join(", ")} or automatic`);
  }
  if (!Number.isFinite(value)) throw refused("a number");
  if (isWhole && !Number.isInteger(value)) throw refused("whole");
  if (value < 0 || (isPositive && value === 0)) throw refused(isPositive ? "positive" : "at least 0");
  if (below !== undefined && value >= below) throw refused(`below ${below / shown.factor} ${shown.name}`.trim());
  return value;
}
