// Charts as a drawing that scales: for reports and slides.

import type { Chart } from "./charts";
import { short } from "./tables";

const [WIDTH, HEIGHT] = [640, 260];
const [LEFT, RIGHT, TOP, BOTTOM] = [64, 12, 26, 42];
/** Points that are less apart, in px, are drawn as one unless a drawing is to be smaller. */
const CLOSE = 0.4;
/** Approximate divisions of an axis. */
const DIVISIONS = 6;

/** Radius in px of the dots of a line that has one at each point. */
export const dotRadius = (width = 2.5): number => width + 1.5;

/** Charts one below the other, in the colours of a light page. */
export function drawing(charts: readonly Chart<never>[], colour: (property: string) => string, near = CLOSE): string {
  const all = charts.map((chart, index) => `<g transform="translate(0 ${index * HEIGHT})">\n${one(chart, colour, near)}</g>\n`);
  const size = `width="${WIDTH}" height="${charts.length * HEIGHT}" viewBox="0 0 ${WIDTH} ${charts.length * HEIGHT}"`;
  const style = "text { font: 12px sans-serif; fill: #17212b } .grid { stroke: #d5dce3 } polyline { fill: none; stroke-width: 1.5 }";
  return `<svg xmlns="http://www.w3.org/2000/svg" ${size}>\n<style>${style}</style>\n<rect width="100%" height="100%" fill="#fff"/>\n${all.join("")}</svg>\n`;
}

function one(chart: Chart<never>, colour: (property: string) => string, near: number): string {
  const { look } = chart;
  const { ranges, lines, shaded } = chart.drawing();
  const [right, bottom] = [WIDTH - RIGHT, HEIGHT - BOTTOM];
  const at = (value: number, [low, high]: [number, number], from: number, to: number) =>
    (from + ((value - low) / (high - low)) * (to - from)).toFixed(2);
  const x = (value: number) => at(value, ranges[0], LEFT, right);
  const y = (value: number) => at(value, ranges[1], bottom, TOP);
  const text = (content: string, attributes: string) =>
    `<text ${attributes}>${content.replaceAll("&", "&amp;").replaceAll("<", "&lt;")}</text>\n`;
  const grid = [
    ...ticks(ranges[0]).map(
      (value) =>
        `<path class="grid" d="M${x(value)} ${TOP}V${bottom}"/>` + text(short(value), `x="${x(value)}" y="${bottom + 16}" text-anchor="middle"`),
    ),
    ...ticks(ranges[1]).map(
      (value) =>
        `<path class="grid" d="M${LEFT} ${y(value)}H${right}"/>` + text(short(value), `x="${LEFT - 6}" y="${y(value)}" dy="4" text-anchor="end"`),
    ),
  ];
  const curves = lines.flatMap(([across, up], index) => {
    const { colour: property, dashed, width, dots } = look.lines[index];
    if (dots === "all") {
      const rows = [...Array(across.length).keys()].filter((row) => !Number.isNaN(up[row]));
      return rows.map((row) => `<circle fill="${colour(property)}" r="${0.6 * dotRadius(width)}" cx="${x(across[row])}" cy="${y(up[row])}"/>\n`);
    }
    const wide = width === undefined ? "" : ` style="stroke-width: ${width}"`;
    const style = `stroke="${colour(property)}"${dashed ? ' stroke-dasharray="5 4"' : ""}${wide}`;
    return pieces(across, up, ranges[0]).map((piece) => {
      const points = apart(piece.map((row) => [Number(x(across[row])), Number(y(up[row]))]), near);
      return `<polyline ${style} points="${points.join(" ")}"/>\n`;
    });
  });
  const [from, to] = (shaded ?? []).map((time) => Number(x(Math.min(Math.max(time, ranges[0][0]), ranges[0][1]))));
  const shade = shaded ? [`<rect x="${from}" y="${TOP}" width="${to - from}" height="${bottom - TOP}" fill="${colour("--empty")}"/>\n`] : [];
  const keys = look.lines.length > 1 ? look.lines : [];
  return [
    text(look.title, `x="${LEFT}" y="17" font-weight="bold"`),
    ...keys.map(({ label, colour: property }, index) =>
      text(label, `x="${right - 130 * (keys.length - 1 - index)}" y="17" text-anchor="end" style="fill: ${colour(property)}"`),
    ),
    ...shade,
    ...grid,
    ...curves,
    `<path d="M${LEFT} ${TOP}V${bottom}H${right}" fill="none" stroke="#5b6875"/>\n`,
    text(look.across ?? "Time in s", `x="${(LEFT + right) / 2}" y="${HEIGHT - 8}" text-anchor="middle"`),
    text(look.up, `transform="translate(14 ${(TOP + bottom) / 2}) rotate(-90)" text-anchor="middle"`),
  ].join("");
}

/** The points of a line that can be distinguished, and the last one. */
function apart(points: [number, number][], near: number): [number, number][] {
  let before = [NaN, NaN];
  return points.filter((point, index) => {
    const isNear = Math.hypot(point[0] - before[0], point[1] - before[1]) < near && index < points.length - 1;
    if (!isNear) before = point;
    return !isNear;
  });
}

/** The rows of a line between its gaps, within a range across. */
function pieces(across: ArrayLike<number>, up: ArrayLike<number>, [low, high]: [number, number]): number[][] {
  const found: number[][] = [[]];
  for (let row = 0; row < across.length; row += 1) {
    if (Number.isNaN(across[row]) || Number.isNaN(up[row])) found.push([]);
    else if (across[row] >= low && across[row] <= high) found[found.length - 1].push(row);
  }
  return found.filter((piece) => piece.length > 1);
}

/** Round values within a range: multiples of 1, 2 or 5 times a power of ten. */
export function ticks([low, high]: [number, number]): number[] {
  const raw = (high - low) / DIVISIONS;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5].find((factor) => factor * power >= raw) ?? 10);
  const first = Math.ceil(low / step - 1e-9);
  const count = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length: Math.max(count, 0) }, (_, index) => Number(((first + index) * step).toPrecision(12)));
}
