// The card of the table: its origin, and the signals of its columns.

import { element, segments } from "../dom";
import { fileDrop } from "../file-drop";
import { short } from "../tables";
import { scaleOf, writtenUnit } from "./columns";
import { EXPERIMENTS, SIGNALS, TAKEN, type ExperimentName, type Signal } from "./signals";
import type { FitContext } from "./study";
import type { Table } from "./table";
import { unitsOf } from "../units";

const ABOUT: Record<ExperimentName, string> = {
  rig: "The valve voltage is given; position and pressures are compared.",
  motion: "The motion of a seal or a tribometer is given; its force is compared.",
};

/** Where a table is dropped or chosen. */
export function dropZone({ study }: FitContext): HTMLElement {
  const example = element("button", { type: "button", onclick: () => void study.example() }, "Try the example");
  const name = study.table && `${study.table.file}: ${study.table.lines.length} rows of ${study.table.names.length} columns`;
  const text = name ?? "Drop a table here (CSV), or choose one. It stays on this machine.";
  return fileDrop({ label: "Open a table", text, open: (file) => study.open(file) }, example);
}

/** The choice of the experiment. */
export function experimentChoice(context: FitContext): HTMLElement {
  const { study, settings } = context;
  const options = EXPERIMENTS.map((name) => [name, name] as const);
  const made = segments("Experiment", options, settings.experiment, (name) => {
    study.choose(name);
    context.open();
  });
  return element("div", { class: "experiment" }, made, element("span", { class: "muted" }, ABOUT[settings.experiment]));
}

/** The columns of the signals of the experiment, with their units. */
export function columnTable(context: FitContext): HTMLElement | null {
  const { study, settings } = context;
  const { table } = study;
  if (!table) return null;
  const head = ["Signal", "Column", "Unit", "Sign", "First value"].map((text) => element("th", { scope: "col" }, text));
  const rows = TAKEN[settings.experiment].map((signal) => row(context, table, signal));
  return element(
    "div",
    { class: "wide" },
    element("table", { class: "columns" }, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)),
  );
}

function row({ study, library }: FitContext, table: Table, signal: Signal): HTMLElement {
  const si = SIGNALS[signal];
  const column = study.columns.get(signal);
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
    const unit = writtenUnit(library.tables, table, place, signal) ?? si;
    change(place < 0 ? undefined : { place, unit, turned: false });
  });
  const scales = unitsOf(library.tables, si);
  const units = element("select", { "aria-label": `Unit of ${signal}` });
  for (const name of scales.keys()) units.append(element("option", { value: name }, name));
  units.value = column?.unit ?? si;
  const written = column ? writtenUnit(library.tables, table, column.place, signal) : null;
  units.disabled = !column;
  units.title = written === null ? "" : `the table says ${written}`;
  units.addEventListener("change", () => column && change({ ...column, unit: units.value }));
  const turned = element("input", { type: "checkbox", "aria-label": `Turn the sign of ${signal}` });
  turned.checked = column?.turned ?? false;
  turned.disabled = !column || signal === "time";
  turned.addEventListener("change", () => column && change({ ...column, turned: turned.checked }));
  const known = column && scales.get(column.unit);
  const scale = known && scaleOf(signal, known);
  const first = column && scale ? (column.turned ? -1 : 1) * (table.columns[column.place][0] * scale.factor + scale.offset) : null;
  const cells: (Node | string)[] = [
    columns,
    units,
    element("label", { class: "turn" }, turned, "opposite"),
    first === null ? "" : `${short(first, 5)} ${si}`,
  ];
  return element("tr", {}, element("th", { scope: "row" }, signal), ...cells.map((cell) => element("td", {}, cell)));
}
