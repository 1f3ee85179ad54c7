// The controls of an input over time.

import { element, segments, slider } from "./dom";
import { sketch } from "./sketch";
import type { Tables } from "./tables";
import { plain, typedAs } from "./units";
import type { Kind, Signal } from "./signal";

/** Scale of a signal: its unit and range. */
export interface Scale {
  label: string;
  unit: string;
  si: string;
  /** Shown value of 1 in SI units. */
  factor: number;
  level: [number, number];
  amplitude: [number, number];
  period: [number, number];
  /** Of the feedback in V/m that keeps a carriage away from its end stops, where there is one. */
  centring?: [number, number];
  /** A constant at which the carriage would stay where it is, and the one that is taken instead when a constant is chosen. */
  apart?: { from: number; to: number };
}

const NAMES: readonly (readonly [Kind, string])[] = [
  ["constant", "Slider"],
  ["sine", "Sine"],
  ["ramp", "Ramp"],
  ["drawn", "Draw"],
];

/** Controls that change a signal in place and say so: its kind with its main slider, and the others. */
export function signalEditor(tables: Tables, signal: Signal, scale: Scale, onChange: () => void): [HTMLElement, HTMLElement] {
  const main = element("div", { class: "signal main" });
  const details = element("div", { class: "signal" });
  const fill = () => {
    const [first, ...others] = controls(tables, signal, scale, onChange);
    main.replaceChildren(first);
    details.replaceChildren(...others);
  };
  const kinds = segments(scale.label, NAMES, signal.kind, (kind) => {
    signal.kind = kind;
    if (kind === "constant" && signal.level === scale.apart?.from) signal.level = scale.apart.to;
    fill();
    onChange();
  });
  fill();
  return [element("div", { class: "signal-editor" }, element("span", { class: "title" }, scale.label), kinds, main), details];
}

/** The sliders of a signal, the main one first. */
function controls(tables: Tables, signal: Signal, scale: Scale, onChange: () => void): HTMLElement[] {
  const part = (label: string, key: "level" | "amplitude" | "period") => {
    const [unit, factor, si] = key === "period" ? ["s", 1, "s"] : [scale.unit, scale.factor, scale.si];
    const [min, max] = scale[key];
    return slider({
      label,
      unit,
      others: typedAs(tables, si, { name: unit, factor, offset: 0 }),
      spelled: (name) => plain(tables.spellings, name),
      min: min * factor,
      max: max * factor,
      step: Number((((max - min) * factor) / 200).toPrecision(1)),
      value: Number((signal[key] * factor).toPrecision(6)),
      onChange: (value) => {
        signal[key] = value / factor;
        onChange();
      },
    });
  };
  const drawing = () =>
    sketch(`${scale.label}, drawn`, signal.points, (points) => {
      signal.points = points;
      onChange();
    });
  const shared = [part("Mean", "level"), part("Period", "period")];
  const centring =
    scale.centring &&
    slider({
      label: "Centring",
      unit: "V/m",
      title: "Feedback that draws the carriage back to where it began; with 0 the loop is open and drifts into an end stop",
      min: scale.centring[0],
      max: scale.centring[1],
      step: 0.1,
      value: signal.centring,
      onChange: (value) => {
        signal.centring = value;
        onChange();
      },
    });
  if (centring) shared.push(centring);
  switch (signal.kind) {
    case "constant":
      return [part("Value", "level"), ...(centring ? [centring] : [])];
    case "sine":
    case "ramp":
      return [part("Amplitude", "amplitude"), ...shared];
    case "drawn":
      return [part("Amplitude", "amplitude"), drawing(), ...shared];
  }
}
