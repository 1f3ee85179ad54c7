// The controls of an input over time.

import { element, segments, slider } from "./dom";
import { sketch } from "./sketch";
import type { Kind, Signal } from "./signal";

/** Scale of a signal: its unit and range. */
export interface Scale {
  label: string;
  unit: string;
  /** Shown value of 1 in SI units. */
  factor: number;
  level: [number, number];
  amplitude: [number, number];
  period: [number, number];
  /** Of the feedback in V/m that keeps a carriage away from its end stops, where there is one. */
  centring?: [number, number];
}

const NAMES: readonly (readonly [Kind, string])[] = [
  ["constant", "Slider"],
  ["sine", "Sine"],
  ["ramp", "Ramp"],
  ["drawn", "Draw"],
];

/** Changes a signal in place and says so. */
export function signalEditor(signal: Signal, scale: Scale, onChange: () => void): HTMLElement {
  const details = element("div", { class: "signal" });
  const fill = () => details.replaceChildren(...controls(signal, scale, onChange));
  const kinds = segments(scale.label, NAMES, signal.kind, (kind) => {
    signal.kind = kind;
    fill();
    onChange();
  });
  fill();
  return element("div", { class: "signal-editor" }, element("span", { class: "title" }, scale.label), kinds, details);
}

function controls(signal: Signal, scale: Scale, onChange: () => void): HTMLElement[] {
  const part = (label: string, key: "level" | "amplitude" | "period") => {
    const [unit, factor] = key === "period" ? ["s", 1] : [scale.unit, scale.factor];
    const [min, max] = scale[key];
    return slider({
      label,
      unit,
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
  const shared = [part("Amplitude", "amplitude"), part("Period", "period")];
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
      return [part("Mean", "level"), ...shared];
    case "drawn":
      return [drawing(), part("Mean", "level"), ...shared];
  }
}
