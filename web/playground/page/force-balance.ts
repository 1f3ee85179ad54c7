// The forces on a carriage, and the range of forces that friction holds at rest: it sticks while the resultant lies inside.

import { element } from "./dom";
import type { Values } from "./library";
import type { Statics } from "./statics";
import { lawName, model, variable } from "./tables";
import type { Context } from "./context";
import { CYLINDER } from "./settings";

/** In ms: the range at rest is asked for at most so often. */
const OFTEN = 100;
/** Parts of the range at rest that are shown, and of the largest force where there is none. */
const ROOM = 1.8;
/** Part of the scale that stays from one picture to the next where there is no range. */
const KEPT = 0.995;

const newton = (force: number): string => `${force.toFixed(1).replace("-", "−")} N`;

export class ForceBalance {
  readonly root: HTMLElement;
  private readonly bars: Record<"a" | "b" | "air" | "pull" | "push", [HTMLElement, HTMLElement]>;
  private readonly band = element("span", { class: "band" });
  private readonly ends = ["low", "high"].map((side) => element("span", { class: `end ${side}` }));
  private readonly resultant = element("span", { class: "resultant" });
  private readonly friction = element("span", { class: "friction-mark", title: "Friction force" });
  private readonly told = element("p", { class: "told", title: "The band: resultant forces that static friction can balance. A law without static friction yields to every force" });
  private held: [number, number] | null = null;
  private asked = -Infinity;
  private scale = 1;
  private whole = 0;

  constructor(
    private readonly context: Context,
    private readonly statics: Statics,
  ) {
    const bar = (kind: string, title: string, ...name: (Node | string)[]): [HTMLElement, HTMLElement] => {
      const value = element("span", {});
      return [element("span", { class: `force ${kind}`, title }, ...name, value), value];
    };
    const chamber = (side: string) => bar("chamber", `Pressure times area of chamber ${side}`, "p", element("sub", {}, side), "A", element("sub", {}, side), " ");
    const load = () => bar("load", "Load: external force, weight, end stops", "load ");
    this.bars = { a: chamber("A"), b: chamber("B"), air: bar("air", "Atmosphere on the rod"), pull: load(), push: load() };
    const [a, b, air, pull, push] = Object.values(this.bars).map(([made]) => made);
    this.root = element(
      "div",
      { class: "balance", role: "img", "aria-label": "Forces on the carriage" },
      element("div", { class: "tug" }, element("div", { class: "minus" }, b, air, pull), element("div", { class: "plus" }, a, push)),
      element("div", { class: "hold" }, this.band, ...this.ends, element("span", { class: "zero" }), this.resultant, this.friction),
      this.told,
    );
  }

  /** Shows the forces of a state: `now` gives variables of the plant, which has the given values. */
  show(now: (name: string) => number, values: Values): void {
    const of = model(this.context.library.tables, CYLINDER);
    const value = (name: string) => values.get(name) ?? variable(of, name).start ?? 0;
    const pressures = [now("chamberA.pressure"), now("chamberB.pressure")] as const;
    const [areaA, areaB] = this.statics.areas(values);
    const [a, b] = [pressures[0] * areaA, pressures[1] * areaB];
    const friction = now("frictionForce");
    const resultant = friction + value("mass.moving") * now("acceleration");
    const chambers = now("pressureForce");
    const load = resultant - chambers;
    this.pull(a, b, a - b - chambers, load);
    const time = performance.now();
    if (time - this.asked > OFTEN) {
      this.asked = time;
      this.held = this.statics.held(values, now("position"), pressures);
    }
    this.hold(resultant, friction, now("sticking") === 1, lawName(this.context.library.tables, value("friction.law")));
  }

  /** Both sides of the tug: each force as long as it is large. */
  private pull(a: number, b: number, air: number, load: number): void {
    this.whole = Math.max(this.whole * KEPT, 1.1 * (a + Math.max(load, 0)), 1.1 * (b + air + Math.max(-load, 0)), 1);
    const forces = { a, b, air, push: load, pull: -load };
    for (const [name, force] of Object.entries(forces)) {
      const [bar, value] = this.bars[name as keyof typeof forces];
      bar.hidden = force < 0.05;
      bar.style.width = `${((100 * Math.max(force, 0)) / this.whole).toFixed(2)}%`;
      value.textContent = name === "air" ? "" : newton(force);
    }
  }

  private hold(resultant: number, friction: number, sticks: boolean, law: string): void {
    const { held } = this;
    const largest = Math.max(Math.abs(resultant), Math.abs(friction), 0.5);
    this.scale = held ? ROOM * Math.max(-held[0], held[1]) : Math.max(this.scale * KEPT, ROOM * Math.min(largest, 4 * Math.abs(friction) + 1));
    const place = (force: number) => 50 + 50 * Math.max(-1, Math.min(1, force / this.scale));
    const from = (one: number, other: number, bar: HTMLElement) => {
      bar.style.left = `${Math.min(place(one), place(other)).toFixed(2)}%`;
      bar.style.width = `${Math.abs(place(other) - place(one)).toFixed(2)}%`;
    };
    this.band.hidden = held === null;
    this.ends.forEach((end, side) => {
      end.hidden = held === null;
      if (!held) return;
      end.style.left = `${place(held[side]).toFixed(2)}%`;
      end.textContent = newton(held[side]);
    });
    if (held) from(...held, this.band);
    from(0, resultant, this.resultant);
    this.friction.style.left = `${place(friction).toFixed(2)}%`;
    this.root.classList.toggle("sticks", sticks);
    this.root.classList.toggle("beyond", Math.abs(resultant) > this.scale);
    this.told.textContent = told(resultant, friction, sticks, held, law);
  }
}

function told(resultant: number, friction: number, sticks: boolean, held: [number, number] | null, law: string): string {
  if (sticks) return `Resultant ${newton(resultant)} inside the band: it sticks`;
  const forces = `Resultant ${newton(resultant)}, friction ${newton(friction)}`;
  return held ? `${forces}: it slides` : `${forces}; ${law} has no band`;
}
