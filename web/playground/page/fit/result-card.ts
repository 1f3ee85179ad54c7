// Result of a fit: values with their intervals, the residual of each signal, and the curves.

import { PathChart, TimeChart, type Chart } from "../charts";
import { element } from "../dom";
import { Refusal } from "../library";
import { displayUnit, items, model, short } from "../tables";
import { toSi, unitsOf } from "../units";
import { scaleOf, type Column } from "./columns";
import type { Answer, Course, Estimate } from "./fit";
import type { Signal } from "./signals";
import type { FitContext, Found } from "./study";

/** Most charts of a preview. */
const PREVIEWED = 4;
/** Most points of a drawn line. */
const DRAWN = 4000;
/** Units of the signals in charts, by SI unit. */
const SHOWN: Record<string, [string, number]> = { m: ["mm", 1e3], "m/s": ["mm/s", 1e3], Pa: ["bar", 1e-5] };

const shownIn = (si: string): [string, number] => SHOWN[si] ?? [si, 1];

/** The tables of a fit, and the button that gives its values to the other pages. */
export function resultTables(context: FitContext, { question, answer }: Found, print: () => void): HTMLElement {
  const estimates = estimateTable(context, answer);
  const left = residualTable(answer);
  const others = answer.findings.slice(1).filter((text) => text !== answer.cause);
  const notes = [
    ...others.map(ended),
    ...noted({ question, answer }),
    ...(answer.validationFrom === null ? [] : [predicted(answer.validationFrom, question.signals.has("time"))]),
  ];
  return element(
    "section",
    { class: "card results", "data-result": answer.converged ? "converged" : "open", "data-light": answer.light },
    ...verdictLines(answer),
    remedy(context, answer) ?? "",
    element("div", { class: "wide" }, estimates),
    element("div", { class: "wide" }, left),
    element("ul", { class: "notes" }, ...notes.map((note) => element("li", {}, note))),
    element(
      "div",
      { class: "buttons" },
      element("button", { type: "button", onclick: () => takeOver(context, answer) }, "Use in the other pages"),
      element("button", { type: "button", title: "One page with values, verdict and curves", onclick: print }, "Print a report"),
    ),
  );
}

/** Notes as sentences; the name of a file stays as it is. */
export const noted = ({ question: { file }, answer: { notes, unitsTold } }: Pick<Found, "question" | "answer">): string[] => [
  ...(unitsTold === null ? [] : [`Units are those ${unitsTold}.`]),
  ...notes.map((note) => (note.startsWith(file) ? `${note}.` : `${note[0].toUpperCase()}${note.slice(1)}.`)),
];

/** What is a prediction of validation data. */
const predicted = (from: number, hasTime: boolean): string =>
  hasTime
    ? `From t = ${short(from)} s on, shaded, the curves are a prediction of validation data.`
    : `From row ${from + 1} of the table on, the points are a prediction of validation data.`;

/** The light with the worst finding, and below it the cause that would explain most of the residual. */
export function verdictLines({ light, head, findings, cause }: Answer): HTMLElement[] {
  const first = findings[0] && findings[0] !== cause ? `${head}: ${findings[0]}.` : `${head}.`;
  const lamp = element("span", { class: `light ${light}`, role: "img", "aria-label": light });
  const sentence = element("p", {}, lamp, element("strong", {}, first));
  return [sentence, ...(cause === null ? [] : [element("p", { "data-cause": "" }, ended(cause))])];
}

/** A button that follows the cause: it estimates the parameter too, or takes the choice or the value of an input, and fits again. */
function remedy(context: FitContext, answer: Answer): HTMLElement | null {
  const { study, library, settings } = context;
  const { name, item, value } = answer.remedy ?? {};
  if (name === undefined) return null;
  const entry = model(library.tables, study.modelName).variables.find((variable) => variable.name === name);
  const again = (change: () => void) => () => {
    change();
    study.start();
  };
  const button = (text: string, change: () => void) => element("div", { class: "buttons" }, element("button", { type: "button", "data-remedy": name, onclick: again(change) }, text));
  const chosen = entry && item !== null ? items(library.tables, entry).find((candidate) => candidate.name === item) : undefined;
  if (entry && chosen) return button(`Set ${name} to ${chosen.name} and fit again`, () => settings.give(study.modelName, entry, chosen.id));
  if (entry?.role === "input" && typeof value === "number") {
    const rounded = Number(value.toPrecision(4));
    const { name: unit, factor, offset } = displayUnit(library.tables, entry);
    return button(`Set ${name} to ${short(rounded * factor + offset)} ${unit} and fit again`, () => settings.give(study.modelName, entry, rounded));
  }
  const { usual, others } = study.estimable;
  const isFree = [...usual, ...others].includes(name) || (entry?.kind === "Real" && entry.role !== "input");
  return isFree && !study.free.includes(name) ? button(`Estimate ${name} too and fit again`, () => study.setFree(name, true)) : null;
}

/** A sentence with its full stop. */
const ended = (text: string): string => (/[.?]$/.test(text) ? text : `${text}.`);

const head = (...texts: string[]) => element("thead", {}, element("tr", {}, ...texts.map((text) => element("th", { scope: "col" }, text))));

/** The estimated values with their intervals. */
export const estimateTable = (context: FitContext, { estimates }: Answer): HTMLElement =>
  element(
    "table",
    { class: "estimates" },
    head("Parameter", "Value", "95 % interval", "Unit"),
    element("tbody", {}, ...estimates.map((estimate) => estimateRow(context, estimate))),
  );

/** The RMS residuals of the fitted and of the validation data. */
export const residualTable = ({ rms, validationRms, units }: Answer): HTMLElement =>
  element(
    "table",
    { class: "left" },
    head("Signal", "RMS residual", "RMS residual, validation", "Unit"),
    element("tbody", {}, ...[...rms].map(([signal, own]) => leftRow(signal, own, validationRms.get(signal), shownIn(units[signal])))),
  );

/** A value with its interval, in the unit in which the form asks for it. */
function estimateRow({ library, study }: FitContext, { name, value, low, high, unit, undetermined }: Estimate): HTMLElement {
  const entry = model(library.tables, study.modelName).variables.find((variable) => variable.name === name);
  const wanted = study.units.get(name) ?? entry?.display ?? unit;
  const scale = unitsOf(library.tables, unit).get(wanted);
  const shown = (si: number) => short(scale ? (si - scale.offset) / scale.factor : si, 5);
  const attributes = { "data-name": name, "data-value": String(value), "data-low": String(low), "data-high": String(high) };
  const interval = undetermined === null || Number.isFinite(high - low) ? `${shown(low)} to ${shown(high)}` : "not told";
  const cells = [shown(value), interval, unit === "1" ? "" : scale ? wanted : unit];
  const row = element("tr", attributes, element("th", { scope: "row" }, name), ...cells.map((cell) => element("td", {}, cell)));
  row.classList.toggle("undetermined", undetermined !== null);
  return row;
}

function leftRow(signal: Signal, rms: number, heldOut: number | undefined, [unit, factor]: [string, number]): HTMLElement {
  const cells = [short(rms * factor), heldOut === undefined ? "" : short(heldOut * factor), unit];
  return element("tr", { "data-signal": signal, "data-rms": String(rms) }, element("th", { scope: "row" }, signal), ...cells.map((cell) => element("td", {}, cell)));
}

/** Gives the fitted values to the settings, so that the other pages run with them. */
function takeOver(context: FitContext, answer: Answer): void {
  const { settings, library, study } = context;
  const of = study.modelName;
  const known = new Map(settings.values[of]);
  const names = new Set(library.tables.models.find(({ name }) => name === of)?.variables.map(({ name }) => name));
  const values = answer.estimates.filter(({ name }) => names.has(name));
  try {
    // All at once: values that suit each other may not suit the present ones.
    for (const { name, value } of values) settings.values[of].set(name, value);
    library.start(7, of, settings.values[of]);
    context.changed();
    context.open();
  } catch (error) {
    if (!(error instanceof Refusal)) throw error;
    settings.values[of] = known;
    context.tell(error.message);
  }
}

/** For each compared signal a chart of measured over simulated values, and one of their difference; validation data are shaded. */
export function curves({ question, answer: { courses, validationFrom, units } }: Found): Chart<never>[] {
  const signals = [...(courses[0]?.measured.keys() ?? [])];
  const axis = axisOf(question.signals, units);
  const across = drawn(courses, ({ across: all }) => all, axis.factor, ({ across: all }) => axis.factor * all[all.length - 1]);
  return signals.flatMap((signal) => {
    const [unit, factor] = shownIn(units[signal]);
    const line = (of: (course: Course) => ArrayLike<number>) => drawn(courses, of, factor, () => NaN);
    const measured = line((course) => course.measured.get(signal) ?? []);
    const simulated = line((course) => course.simulated.get(signal) ?? []);
    const both = chart(signal, unit, ["simulated", "measured"], axis, across, [simulated, measured], validationFrom);
    const difference = measured.map((value, index) => value - simulated[index]);
    return [both, chart(`${signal}: residual`, unit, ["residual"], axis, across, [difference], validationFrom)];
  });
}

/** The measured signals as they will be taken, before a fit. */
export function preview({ library, study: { table, columns } }: FitContext): Chart<never>[] {
  const rows = table?.lines.length ?? 0;
  const stride = Math.max(Math.ceil(rows / DRAWN), 1);
  const taken = ([signal, { place, unit, turned }]: [Signal, Column]): [Signal, Float64Array, string] | null => {
    const scale = scaleOf(library, signal, unit);
    const drawn = table?.columns[place].filter((_, row) => row % stride === 0);
    return typeof scale !== "string" && drawn ? [signal, toSi(drawn, scale, turned), scale.si] : null;
  };
  const signals = [...columns].slice(0, PREVIEWED + 1).flatMap((column) => [taken(column)].filter((one) => one !== null));
  const axis = axisOf(columns, Object.fromEntries(signals.map(([signal, , si]) => [signal, si])));
  const [, across] = signals.find(([signal]) => signal === axis.signal) ?? [];
  if (!across) return [];
  return signals
    .filter(([signal]) => signal !== axis.signal)
    .map(([signal, values, si]) => {
      const [unit, factor] = shownIn(si);
      const line = Array.from(values, (value) => value * factor);
      return chart(signal, unit, ["measured"], axis, Array.from(across, (value) => value * axis.factor), [line], null);
    });
}

/** What stands across a chart: the time, or the velocity of points, which have none. */
interface Axis {
  signal: Signal;
  unit: string;
  factor: number;
}

function axisOf(signals: ReadonlyMap<Signal, unknown>, units: Record<Signal, string>): Axis {
  const signal = signals.has("time") ? "time" : "velocity";
  const [unit, factor] = shownIn(units[signal]);
  return { signal, unit, factor };
}

const COLOURS: Record<string, string> = { measured: "--line-2", simulated: "--line-1", residual: "--line-3" };
/** The simulated curve is the wider one, so that it shows beside the measured one over it. */
const WIDTHS: Record<string, number> = { simulated: 4, measured: 1.5 };

function chart(title: string, up: string, labels: string[], axis: Axis, across: number[], lines: number[][], validationFrom: number | null): Chart<never> {
  const look = labels.map((label) => ({ label, colour: COLOURS[label], width: WIDTHS[label] }));
  const last = across[across.length - 1];
  if (axis.signal !== "time") {
    const points = look.map((line) => ({ ...line, dots: "all" as const }));
    const made = new PathChart({ title, across: `${axis.signal} in ${axis.unit}`, up, lines: points, span: 1e-3 });
    made.show(lines.map((line) => [across, line]), [across[0], last]);
    return made;
  }
  const made = new TimeChart({ title, up, lines: look, span: 1e-3 });
  made.show({ times: across, lines, ...(validationFrom === null ? {} : { shaded: [validationFrom, last] }) }, [across[0], last]);
  return made;
}

/** Values of all stretches, as many as fit on the pixels; behind each stretch, a value for the gap. */
function drawn(
  courses: Course[],
  of: (course: Course) => ArrayLike<number>,
  factor: number,
  gap: (course: Course) => number,
): number[] {
  const rows = courses.reduce((total, { across }) => total + across.length, 0);
  const stride = Math.max(Math.ceil(rows / DRAWN), 1);
  return courses.flatMap((course) => {
    const values = of(course);
    const found: number[] = [];
    for (let row = 0; row < values.length; row += stride) found.push(values[row] * factor);
    return [...found, gap(course)];
  });
}
