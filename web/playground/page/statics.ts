// What holds a cylinder's carriage at rest, as the plant itself has it: it is started at a state and asked.

import { Refusal, TRIAL, type Library, type Values } from "./library";
import { CYLINDER } from "./settings";
import { items, model, variable } from "./tables";

/** In Pa. */
const STEP = 1e5;

export class Statics {
  /** The setting that moves the carriage as imposed. */
  private readonly imposed: number;
  private known: { of: string; areas: [number, number] } | null = null;

  constructor(private readonly library: Library) {
    const { tables } = library;
    this.imposed = items(tables, variable(model(tables, CYLINDER), "motion")).find(({ name }) => name === "Imposed")?.id ?? 0;
  }

  /** Areas in m2 on which the chambers press: the force of the chambers is linear in their pressures. */
  areas(values: Values): [number, number] {
    const of = JSON.stringify([...values]);
    if (this.known?.of !== of) {
      const force = (a: number, b: number) => this.ask(this.under(values, a, b, true), ["pressureForce"])[0];
      const none = force(STEP, STEP);
      this.known = { of, areas: [(force(2 * STEP, STEP) - none) / STEP, (none - force(STEP, 2 * STEP)) / STEP] };
    }
    return this.known.areas;
  }

  /**
   * The least and the largest force in N on the carriage at which friction holds it, at a position in m and pressures in Pa;
   * nothing for a law that holds no range of forces.
   */
  held(values: Values, position: number, pressures: readonly [number, number]): [number, number] | null {
    const start = this.under(values, ...pressures).set("motion", this.imposed).set("imposedPosition", position);
    try {
      const [low, high] = this.ask(start, ["frictionForceLimit.low", "frictionForceLimit.high"]);
      return high > low ? [low, high] : null;
    } catch (error) {
      // Some options do not go with an imposed motion.
      if (!(error instanceof Refusal)) throw error;
      return null;
    }
  }

  private under(values: Values, a: number, b: number, isClosed = false): Map<string, number> {
    const closed: [string, number][] = isClosed ? [["chamberA.open", 0], ["chamberB.open", 0]] : [];
    return new Map([...values, ["chamberA.pressure0", a], ["chamberB.pressure0", b], ...closed]);
  }

  private ask(values: Values, names: readonly string[]): number[] {
    return Array.from(this.library.start(TRIAL, CYLINDER, values).reader(names)());
  }
}
