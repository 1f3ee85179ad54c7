// Objects that the parts of the page share.

import type { Chart } from "./charts";
import type { Library } from "./library";
import type { Settings } from "./settings";

export interface Context {
  library: Library;
  settings: Settings;
  /** Shows the page of the present settings anew. */
  open(): void;
  /** Shows a problem, or takes it away. */
  tell(problem: string | null): void;
  /** Gives a variable a value; throws a refusal, and changes nothing then. */
  change(model: string, variable: string, value: number): void;
  /** Gives several variables of a model their values at once, and shows the page anew; throws a refusal, and changes nothing then. */
  changeAll(model: string, values: ReadonlyMap<string, number>): void;
  /** To be called when a setting has changed that a link restores. */
  changed(): void;
}

/** Files to export. */
export interface Files {
  /** The names of the files without their endings; each export of another run or instant has its own. */
  name: string;
  csv: string;
  ssv: string;
  /** Reading it throws a refusal where no program can repeat the run. */
  readonly python: string;
  /** Charts of the run. */
  charts: readonly Chart<never>[];
}

/** One of the pages between which a visitor chooses. */
export interface Page {
  readonly root: HTMLElement;
  /** Variables that the page itself sets, as `model.variable`. */
  readonly driven: readonly string[];
  /** Shows the state at a time in ms of the wall clock. */
  frame(now: number): void;
  /** Takes over a value that was changed; throws a refusal. */
  change(model: string, name: string, value: number, isLive: boolean): void;
  files(): Files | null;
}
