// Measured friction over velocity, from a table of the visitor: the friction law Table.

import { PathChart } from "./charts";
import type { Context } from "./context";
import { element } from "./dom";
import { fileDrop } from "./file-drop";
import { checkColumn } from "./fit/columns";
import { begin } from "./fit/job";
import { TableError, type Table } from "./fit/table";
import { plain, toSi, unitsOf } from "./units";
import { Refusal, TRIAL } from "./library";
import { BENCH } from "./settings";
import { laws, model, short, variable, type Variable } from "./tables";

const LAW = "Table";
const GROUP = "friction.table.";
const SIDES = [["outwards", 1], ["inwards", -1]] as const;
/** The item of `bench.drive` that moves the mass with a velocity. */
const PRESCRIBED = 2;
/** Speeds at which each direction is drawn, and by how much they go beyond the last point. */
const [DRAWN, BEYOND] = [60, 1.1];
const MM = 1e3;

export class FrictionCurve {
  readonly root = element("details", { class: "card parameters curve" });
  private readonly chart = new PathChart({
    title: "Friction over velocity at load factor 1",
    across: "Velocity in mm/s",
    up: "Friction force in N",
    lines: [
      { label: "law", colour: "--line-1", dots: "none" },
      { label: "points", colour: "--line-2", dots: "all" },
    ],
    span: 2,
  });
  private readonly about = element("p", { class: "muted", "data-curve": true });
  private readonly problem = element("p", { class: "problem", role: "alert", "data-curve-problem": true });
  private read = "";

  constructor(private readonly context: Context) {}

  /** Shows the curve of the present model; nothing where a fit asks for the friction. */
  show(): void {
    const of = this.model;
    this.root.hidden = of === null;
    if (of === null) {
      this.root.replaceChildren();
      return;
    }
    const isTable = this.value(of, "friction.law") === this.law;
    const text = "Drop a table of velocity and force here (CSV), or choose one. It becomes the friction law Table.";
    if (!this.root.hasChildNodes()) {
      const drop = fileDrop({ label: "Open measured friction", text, open: (file) => this.open(file) });
      const summary = element("summary", {}, element("h2", {}, "Measured friction"));
      this.root.replaceChildren(summary, drop, this.problem, this.about, this.chart.root);
    }
    if (isTable) this.root.open = true;
    this.about.textContent = isTable ? [this.read, ...SIDES.map(([side]) => this.told(of, side))].filter(Boolean).join(" ") : "";
    this.chart.root.hidden = !isTable;
    if (isTable) this.draw(of);
  }

  /** The model of the page whose friction it is. */
  private get model(): string | null {
    return this.context.settings.view === "fit" ? null : this.context.settings.models[0];
  }

  private get law(): number {
    return laws(this.context.library.tables).find(({ name }) => name === LAW)?.id ?? NaN;
  }

  private value(of: string, name: string): number {
    const { settings, library } = this.context;
    return settings.values[of].get(name) ?? variable(model(library.tables, of), name).start ?? 0;
  }

  /** The points of a direction: speeds in m/s and forces in N. */
  private points(of: string, side: string): [number, number][] {
    const places = Array.from({ length: this.value(of, `${GROUP}${side}.points`) }, (_, place) => place + 1);
    return places.map((place) => [this.value(of, `${GROUP}${side}.speed[${place}]`), this.value(of, `${GROUP}${side}.force[${place}]`)]);
  }

  private told(of: string, side: string): string {
    const points = this.points(of, side);
    const [[from, force], [to]] = [points[0], points[points.length - 1]];
    return `${points.length} points ${side} from ${short(MM * from)} to ${short(MM * to)} mm/s, breaking away at ${short(force)} N.`;
  }

  /** Reads a table in a worker and takes it over. */
  private open(file: File): void {
    begin({ kind: "read", module: this.context.library.module, file }, (reply) => {
      if (reply.kind === "problem") this.problem.textContent = reply.text;
      if (reply.kind === "table") this.take(reply.table);
    });
  }

  private take(table: Table): void {
    const { library } = this.context;
    const of = this.model;
    if (of === null) return;
    try {
      const [velocity, force] = library.frictionColumns(table.file, table.names);
      const settings = library.frictionTable(table.file, this.column(table, velocity, "m/s"), this.column(table, force, "N"), table.lines);
      const own = model(library.tables, of).variables.filter(({ name }) => name.startsWith(GROUP));
      const defaults = own.map(({ name, start }: Variable) => [name, start ?? 0] as const);
      const before = this.read;
      this.read = `${table.file}: ${table.lines.length} rows.`;
      try {
        this.context.changeAll(of, new Map([["friction.law", this.law], ...defaults, ...settings]));
      } catch (error) {
        this.read = before;
        throw error;
      }
      this.problem.textContent = "";
    } catch (error) {
      if (!(error instanceof Refusal || error instanceof TableError)) throw error;
      this.problem.textContent = error.message;
    }
  }

  /** A column in SI units; throws an error for a unit of another quantity. */
  private column(table: Table, place: number, si: string): Float64Array {
    checkColumn(table, place);
    const units = unitsOf(this.context.library.tables, si);
    const unit = table.units[place] ?? si;
    const scale = units.get(plain(this.context.library.tables.spellings, unit));
    if (!scale) {
      const where = `${table.file}:${table.first}, column ${place + 1} (${table.names[place]})`;
      throw new TableError(`${where}: the unit ${unit} is refused; it must be one of ${[...units.keys()].join(", ")}`);
    }
    return toSi(table.columns[place], scale, false);
  }

  /** Draws what the law answers on the bench, and the points. */
  private draw(of: string): void {
    const { library } = this.context;
    const bench = model(library.tables, BENCH).variables.map(({ name }) => name);
    const isOfCurve = (name: string) => name.startsWith(GROUP) || name.startsWith("friction.direction.");
    const own = bench.filter(isOfCurve).map((name) => [name, this.value(of, name)] as const);
    const values = new Map([["friction.law", this.law], ...own, ["bench.drive", PRESCRIBED]]);
    const [line, points]: [[number, number][], [number, number][]] = [[], []];
    for (const [side, sign] of [...SIDES].reverse()) {
      const known = this.points(of, side);
      const last = known[known.length - 1][0];
      const speeds = Array.from({ length: DRAWN }, (_, at) => last * BEYOND * (Math.max(at, 1e-6) / (DRAWN - 1)) ** 2);
      const half = speeds.map((speed): [number, number] => {
        const bench = library.start(TRIAL, BENCH, new Map([...values, ["driveVelocity", sign * speed]]));
        return [sign * speed * MM, bench.reader(["frictionForce"])()[0]];
      });
      // From the left to the right; at rest the force is any up to the first.
      line.push(...(sign < 0 ? half.reverse() : half));
      points.push(...known.map(([speed, force]): [number, number] => [sign * speed * MM, sign * force]));
    }
    const path = (all: [number, number][]) => [all.map(([across]) => across), all.map(([, up]) => up)] as const;
    this.chart.show([path(line), path(points)], [0, 0]);
  }
}
