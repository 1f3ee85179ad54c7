// The card of the table: its origin, and the signals of its columns.

import { element, segments } from "../dom";
import { fileDrop } from "../file-drop";
import { experiment, short } from "../tables";
import { scaleOf, unitNames, writtenUnit } from "./columns";
import type { Signal } from "./signals";
import type { FitContext } from "./study";
import type { Table } from "./table";
import { unitsOf } from "../units";

/** Stands in the list of units for a calibration by two points. */
const BY_TWO_POINTS = "";

/** Where a table is dropped or chosen. */
export function dropZone({ study }: FitContext): HTMLElement {
  const example = element("button", { type: "button", onclick: () => void study.example() }, "Try the example");
  const name = study.table && `${study.table.file}: ${study.table.lines.length} rows of ${study.table.names.length} columns`;
  const text = name ?? "Drop a table here (CSV), or choose one. It stays on this machine.";
  return fileDrop({ label: "Open a table", text, open: (file) => study.open(file) }, example);
}

/** The choice of the experiment. */
export function experimentChoice(context: FitContext): HTMLElement {
  const { study, settings, library } = context;
  const options = library.tables.experiments.map(({ name }) => [name, name] as const);
  const made = segments("Experiment", options, settings.experiment, (name) => {
    study.choose(name);
    context.open();
  });
  return element("div", { class: "experiment" }, made, element("span", { class: "muted" }, experiment(library.tables, settings.experiment).about));
}

/** The columns of the signals of the experiment, with their units. */
export function columnTable(context: FitContext): HTMLElement | null {
  const { study, settings, library } = context;
  const { table } = study;
  if (!table) return null;
  const head = ["Signal", "Column", "Unit", "Sign", "First value"].map((text) => element("th", { scope: "col" }, text));
  const rows = experiment(library.tables, settings.experiment).signals.map((signal) => row(context, table, signal));
  return element(
    "div",
    { class: "wide" },
    element("table", { class: "columns" }, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)),
  );
}

function row(context: FitContext, table: Table, signal: Signal): HTMLElement {
  const { study, library, settings } = context;
  const column = study.columns.get(signal);
  const scale = column && scaleOf(library, signal, column.unit);
  const si = (typeof scale === "object" && scale.si) || library.tables.signals[signal];
  const change = (next: typeof column) => {
    if (next) study.columns.set(signal, next);
    else study.columns.delete(signal);
    study.shown();
  };
  const columns = element("select", { "aria-label": `Column of ${signal}` }, element("option", { value: "-1" }, "none"));
  table.names.forEach((name, place) => columns.append(element("option", { value: String(place) }, name)));
  columns.value = String(column?.place ?? -1);
  columns.addEventListener("change", () => {
    const place = Number(columns.value);
    const unit = writtenUnit(library, table, place, signal) ?? si;
    change(place < 0 ? undefined : { place, unit, turned: false });
  });
  const names = unitNames(library, experiment(library.tables, settings.experiment), signal, column?.unit);
  const units = element("select", { "aria-label": `Unit of ${signal}` });
  for (const name of names) units.append(element("option", { value: name }, name));
  if (signal !== "time") units.append(element("option", { value: BY_TWO_POINTS }, "two points"));
  const isCalibrated = column !== undefined && !names.includes(column.unit);
  units.value = isCalibrated ? BY_TWO_POINTS : (column?.unit ?? si);
  const written = column ? writtenUnit(library, table, column.place, signal) : null;
  units.disabled = !column;
  units.title = written === null ? "" : `the table says ${written}`;
  units.addEventListener("change", () => column && change({ ...column, unit: units.value }));
  const turned = element("input", { type: "checkbox", "aria-label": `Turn the sign of ${signal}` });
  turned.checked = column?.turned ?? false;
  turned.disabled = !column || signal === "time";
  turned.addEventListener("change", () => column && change({ ...column, turned: turned.checked }));
  const first = column && scale && typeof scale !== "string" ? (column.turned ? -1 : 1) * (table.columns[column.place][0] * scale.factor + scale.offset) : null;
  const cells: (Node | string)[] = [
    columns,
    isCalibrated ? element("div", { class: "calibration" }, units, calibration(context, signal, column.unit, scale, (unit) => change({ ...column, unit }))) : units,
    element("label", { class: "turn" }, turned, "opposite"),
    first === null ? "" : `${short(first, 5)} ${si}`,
  ];
  return element("tr", {}, element("th", { scope: "row" }, signal), ...cells.map((cell) => element("td", {}, cell)));
}

/** The field for a calibration by two points, with what is wrong with it. */
function calibration({ library }: FitContext, signal: Signal, text: string, scale: unknown, change: (unit: string) => void): HTMLElement {
  const [, shown] = unitsOf(library.tables, library.tables.signals[signal]).keys();
  const input = element("input", {
    type: "text",
    "aria-label": `Calibration of ${signal}`,
    placeholder: `0..10 V = 0..500 ${shown}`,
    value: text,
    onchange: () => change(input.value.trim()),
  });
  const problem = typeof scale === "string" && text !== BY_TWO_POINTS ? scale : "";
  return element("div", {}, input, element("span", { class: "problem", role: "alert" }, problem));
}
