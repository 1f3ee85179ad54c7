// Findings about a record before it is fitted, and the buttons that follow their remedies.

import { element } from "../dom";
import { model, short } from "../tables";
import { scaleOf } from "./columns";
import type { Signal } from "./signals";
import type { FitContext } from "./study";

export type Remedy =
  | { kind: "unit"; signal: Signal; unit: string }
  | { kind: "turn"; signal: Signal }
  | { kind: "swap"; signals: [Signal, Signal] }
  /** Names and values in SI units. */
  | { kind: "set"; values: [string, number][] }
  | { kind: "remove"; signal: Signal; rows: number[] };

/** Something about a signal that cannot be meant, or is unlikely. */
export interface Finding {
  signal: Signal;
  text: string;
  /** The likeliest first. */
  remedies: Remedy[];
  /** Whether no fit makes sense with it. */
  refused: boolean;
}

/** The findings about the record, each with buttons for its remedies; nothing if there are none. */
export function findingList(context: FitContext): HTMLElement | null {
  const { study } = context;
  if (!study.findings.length) return null;
  const one = (finding: Finding) => {
    const isFarOff = finding.refused && finding.remedies.some(({ kind }) => kind === "remove");
    const about = isFarOff ? "Correct or remove the sample in the table." : "";
    const buttons = finding.remedies.map((remedy) => button(context, remedy));
    const text = element("p", finding.refused ? { class: "problem" } : {}, about ? `${finding.text}. ${about}` : finding.text);
    return element("li", { "data-finding": finding.signal }, text, element("div", { class: "buttons" }, ...buttons));
  };
  const list = element("ul", { class: "findings" }, ...study.findings.map(one));
  return element("div", { role: "alert", "aria-label": "Findings about the record" }, list);
}

/** Properties of sensors that remedies or a link have set, and rows that are left out, which no other part of the page shows. */
export function sensorList({ study, settings }: FitContext): HTMLElement | null {
  const { unseen: sensors, estimable: { units } } = study;
  const leftOut = settings.leftOut.length;
  if (!sensors.length && !leftOut) return null;
  const told = sensors.map(([name, value]) => {
    const unit = units[name] ?? "1";
    return `${name} = ${short(value, 6)}${unit === "1" ? "" : ` ${unit}`}`;
  });
  if (leftOut) told.push(`${leftOut} ${leftOut === 1 ? "row" : "rows"} left out`);
  const forget = () => {
    for (const [name] of sensors) settings.beside.delete(name);
    settings.leftOut = [];
    study.changed();
  };
  return element("p", { class: "sensors" }, `Corrected readings: ${told.join(", ")} `, element("button", { type: "button", onclick: forget }, "Take them as they are"));
}

const button = (context: FitContext, remedy: Remedy): HTMLElement =>
  element("button", { type: "button", onclick: () => follow(context, remedy) }, named(context, remedy));

function named({ library }: FitContext, remedy: Remedy): string {
  switch (remedy.kind) {
    case "unit": {
      const { signal, unit } = remedy;
      const isGauge = library.tables.signals[signal] === "Pa" && unit.endsWith("g");
      return isGauge ? `Take it as ${unit.slice(0, -1)} above the atmosphere` : `Take it in ${unit}`;
    }
    case "turn":
      return `Turn the sign of ${remedy.signal}`;
    case "swap":
      return remedy.signals.every((signal) => signal.startsWith("chamber")) ? "Swap the chambers" : `Swap ${remedy.signals.join(" and ")}`;
    case "set":
      return `Set ${remedy.values.map(([name, value]) => `${name} = ${short(value, 6)}`).join(", ")}`;
    case "remove":
      return remedy.rows.length === 1 ? "Leave this row out" : `Leave these ${remedy.rows.length} rows out`;
  }
}

/** Changes columns, sensors or settings as a remedy says. */
function follow(context: FitContext, remedy: Remedy): void {
  const { study, library, settings } = context;
  const { columns } = study;
  const change = (signal: Signal, changes: { unit: string } | { turned: boolean }) => {
    const column = columns.get(signal);
    if (column) columns.set(signal, { ...column, ...changes });
  };
  if (remedy.kind === "unit" && typeof scaleOf(library, remedy.signal, remedy.unit) !== "string") change(remedy.signal, { unit: remedy.unit });
  if (remedy.kind === "turn") change(remedy.signal, { turned: !columns.get(remedy.signal)?.turned });
  if (remedy.kind === "swap") {
    const [one, other] = remedy.signals;
    const [first, second] = [columns.get(one), columns.get(other)];
    if (first && second) {
      columns.set(one, second);
      columns.set(other, first);
    }
  }
  if (remedy.kind === "remove") {
    const lines = remedy.rows.flatMap((row) => study.table?.lines[row] ?? []);
    settings.leftOut = [...settings.leftOut, ...lines].sort((one, other) => one - other);
  }
  if (remedy.kind === "set") {
    const { variables } = model(library.tables, study.modelName);
    for (const [name, value] of remedy.values) {
      if (variables.some((variable) => variable.name === name)) context.change(study.modelName, name, value);
      else settings.beside.set(name, value);
    }
  }
  study.changed();
}
