// Charts over time and of one quantity over another, drawn by uPlot in the colours of the page.

import uPlot from "uplot";
import { element } from "./dom";
import type { Episodes } from "./episodes";
import { dotRadius } from "./svg";
import { short } from "./tables";

export interface Line {
  label: string;
  /** Name of the custom property with its colour. */
  colour: string;
  dashed?: boolean;
  /** Width in px. */
  width?: number;
  /** Dots of a chart of one quantity over another: where it is now, unless all points are dots, or none has one. */
  dots?: "all" | "none";
}

export interface Look {
  title: string;
  /** Label of the horizontal axis, for charts of one quantity over another. */
  across?: string;
  up: string;
  lines: Line[];
  /** Whether the area between the first two lines is marked. */
  marked?: boolean;
  /** Whether it shows where the carriage sticks, breaks away, and rests against an end stop. */
  episodes?: boolean;
  /** The smallest range of the vertical axis. */
  span?: number;
}

/** Contents of a chart over time. */
export interface Curves {
  times: ArrayLike<number>;
  lines: ArrayLike<number>[];
  episodes?: Episodes;
  /** Range of time that is shaded. */
  shaded?: [number, number];
}

/** Contents of a chart of one quantity over another: a path for each line. */
export type Paths = readonly (readonly [ArrayLike<number>, ArrayLike<number>])[];

/** A chart and what it shows of a run. */
export class Plot<D = unknown> {
  constructor(
    private readonly chart: Chart<D>,
    private readonly of: () => D,
  ) {}

  /** Draws it over a range of time, before the same of a run that was kept. */
  draw(range: [number, number], kept?: Plot<D>): void {
    this.chart.show(this.of(), range, kept?.of());
  }
}

/** Size on a full screen, for a lecture. */
const lecture = (): number => (document.fullscreenElement ? Math.max(innerHeight / 760, 1) : 1);
/** The narrowest part of a chart in px that is enlarged: less is a click. */
const NARROWEST = 6;

/** In ms: a text of the course is renewed at most so often. */
const OFTEN = 2000;

const probe = element("span", { hidden: true });

/** The colour that a custom property has in the present theme, or in a given one. */
export function css(name: string, scheme = ""): string {
  if (!probe.isConnected) document.body.append(probe);
  probe.style.colorScheme = scheme;
  probe.style.color = `var(${name})`;
  return getComputedStyle(probe).color;
}

const clamp = (value: number, low: number, high: number): number => Math.min(Math.max(value, low), high);

/** A range with some air, at least so wide. */
function airy(low: number | null, high: number | null, span: number): [number, number] {
  if (low === null || high === null || !Number.isFinite(low + high)) return [-span / 2, span / 2];
  const middle = (low + high) / 2;
  const half = Math.max((high - low) * 0.54, span / 2);
  return [middle - half, middle + half];
}

function axis(label: string, height?: number): uPlot.Axis {
  const size = lecture();
  return {
    label,
    stroke: css("--muted"),
    grid: { stroke: css("--grid"), width: 1 },
    ticks: { stroke: css("--grid"), width: 1, size: 4 },
    font: `${11 * size}px system-ui, sans-serif`,
    labelFont: `${11 * size}px system-ui, sans-serif`,
    labelSize: 16 * size,
    labelGap: 0,
    size: (height ?? 46) * size,
    values: (_, splits) => splits.map((value) => short(value, 6)),
  };
}

/** Style of a line. */
function stroke(line: Line): uPlot.Series {
  return {
    label: line.label,
    stroke: css(line.colour),
    width: (line.width ?? 1.5) * lecture(),
    points: { show: false },
    ...(line.dashed ? { dash: [5, 4] } : {}),
  };
}

/** The keys of what is marked over time. */
const keys = (): HTMLElement[] =>
  [["stick", "sticks"], ["break-away", "breaks away"], ["stop", "end stop"]].map(([name, label]) =>
    element("span", {}, element("span", { class: `patch ${name}` }), label),
  );

/** Draws through points, with a gap where one is NaN. */
function trace(plot: uPlot, across: ArrayLike<number>, up: ArrayLike<number>): void {
  const { ctx } = plot;
  ctx.beginPath();
  let isGap = true;
  for (let row = 0; row < across.length; row += 1) {
    if (Number.isNaN(across[row])) {
      isGap = true;
      continue;
    }
    const point = [plot.valToPos(across[row], "x", true), plot.valToPos(up[row], "y", true)] as const;
    if (isGap) ctx.moveTo(...point);
    else ctx.lineTo(...point);
    isGap = false;
  }
  ctx.stroke();
}

/** Draws within the axes of a chart. */
function within(plot: uPlot, draw: (ctx: CanvasRenderingContext2D) => void): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.lineWidth = 1.5 * devicePixelRatio;
  ctx.lineJoin = "round";
  ctx.setLineDash([]);
  draw(ctx);
  ctx.restore();
}

/** The least and the largest of values, together with an earlier range. */
function extremes(from: [number | null, number | null], others: readonly ArrayLike<number>[]): [number | null, number | null] {
  let [low, high] = from;
  for (const values of others) {
    for (let row = 0; row < values.length; row += 1) {
      const value = values[row];
      if (Number.isNaN(value)) continue;
      if (low === null || value < low) low = value;
      if (high === null || value > high) high = value;
    }
  }
  return [low, high];
}

/** A chart in the page; it is drawn anew when its width or the colours change. */
export abstract class Chart<D> {
  readonly root: HTMLElement;
  protected plot: uPlot | null = null;
  /** Tells the values at the pointer. */
  protected readonly values = element("output", { class: "values", hidden: true });
  private readonly holder = element("div", { class: "plot" });

  constructor(readonly look: Look) {
    const legend = element("div", { class: "legend" });
    for (const line of look.lines) {
      const key = element("span", { class: line.dashed ? "key dashed" : "key", style: `--line: var(${line.colour})` });
      legend.append(element("span", {}, key, line.label));
    }
    const ofLines = look.lines.length > 1 ? [...legend.children] : [];
    legend.replaceChildren(...ofLines, ...(look.episodes ? keys() : []));
    const title = element("figcaption", {}, element("strong", {}, look.title), legend.children.length ? legend : null, this.values);
    this.root = element("figure", { class: "chart", role: "img", "aria-label": look.title }, title, this.holder);
    new ResizeObserver(() => this.fit()).observe(this.holder);
    for (const change of ["themechange", "fullscreenchange"]) addEventListener(change, () => this.redraw());
  }

  /** Shows data over a range of time, in front of the kept run. */
  abstract show(data: D, range: [number, number], kept?: D): void;
  /** Ranges of both axes, and the points of each line. */
  abstract drawing(): { ranges: [[number, number], [number, number]]; lines: Paths; shaded?: [number, number] };
  protected abstract options(): Omit<uPlot.Options, "width" | "height">;
  protected abstract data(): uPlot.AlignedData;

  /** Draws what the data are now. */
  protected update(): void {
    this.plot?.setData(this.data());
  }

  private redraw(): void {
    this.plot?.destroy();
    this.plot = null;
    this.fit();
  }

  private fit(): void {
    const width = Math.floor(this.holder.clientWidth);
    if (width === 0 || !this.root.isConnected) return;
    const height = this.holder.clientHeight;
    if (this.plot) {
      if (this.plot.width !== width) this.plot.setSize({ width, height });
      return;
    }
    const options = { ...this.options(), width, height, legend: { show: false } };
    this.plot = new uPlot(options, this.data(), this.holder);
  }
}

/** Lines over time. */
export class TimeChart extends Chart<Curves> {
  /** Hears of the range of time that the visitor wants to see, or that he wants to see what there is. */
  onZoom: ((range: [number, number] | null) => void) | null = null;
  private curves: Curves = { times: [0], lines: this.look.lines.map(() => [NaN]) };
  private range: [number, number] = [0, 1];
  private described = -Infinity;
  private kept: Curves | undefined;

  show(curves: Curves, range: [number, number], kept?: Curves): void {
    this.curves = curves;
    this.range = range;
    this.kept = kept;
    this.update();
    this.tell();
    this.describe();
  }

  /** Tells the course of each line in words, for those who do not see it. */
  private describe(): void {
    const now = performance.now();
    if (now - this.described < OFTEN) return;
    this.described = now;
    const { times, lines } = this.curves;
    const unit = / in (.*)$/.exec(this.look.up)?.[1] ?? "";
    const texts = lines.map((line, index) => {
      const [low, high] = extremes([null, null], [line]);
      const [begin, end] = [line[0], line[line.length - 1]].map((value) => short(value, 4));
      return low === null || high === null ? "" : `${this.look.lines[index].label} from ${begin} to ${end} ${unit}, between ${short(low, 4)} and ${short(high, 4)} ${unit}`;
    });
    const [from, to] = [times[0], times[times.length - 1]].map((time) => short(time, 4));
    const breaks = this.curves.episodes ? `; it breaks away ${this.curves.episodes.breakAways.length} times` : "";
    this.root.setAttribute("aria-description", `From ${from} to ${to} s: ${texts.filter(Boolean).join("; ")}${breaks}`);
  }

  drawing() {
    const lines = this.curves.lines.map((line) => [this.curves.times, line] as const);
    const [low, high] = extremes([null, null], this.curves.lines);
    return { ranges: [this.range, airy(low, high, this.look.span ?? 1)] as [[number, number], [number, number]], lines, shaded: this.curves.shaded };
  }

  /** Shades a range of time, where the carriage sticks or rests against a stop, under grid and lines, and draws the run that was kept. */
  private readonly shade = (plot: uPlot): void => {
    const { bbox, valToPos } = plot;
    const { episodes, shaded } = this.curves;
    within(plot, (ctx) => {
      const fill = (intervals: [number, number][], colour: string) => {
        ctx.fillStyle = css(colour);
        for (const interval of intervals) {
          const [from, to] = interval.map((time) => clamp(valToPos(time, "x", true), bbox.left, bbox.left + bbox.width));
          ctx.fillRect(from, bbox.top, Math.max(to - from, 0), bbox.height);
        }
      };
      if (shaded) fill([shaded], "--empty");
      if (episodes) {
        fill(episodes.sticking, "--stick");
        fill(episodes.stops, "--stop");
      }
      ctx.strokeStyle = css("--kept");
      ctx.lineWidth *= 2;
      for (const line of this.kept?.lines ?? []) trace(plot, this.kept?.times ?? [], line);
    });
  };

  /** Points down to where the carriage breaks away. */
  private readonly point = ({ ctx, bbox, valToPos }: uPlot): void => {
    const size = 5 * devicePixelRatio;
    ctx.save();
    ctx.fillStyle = css("--held");
    for (const time of this.curves.episodes?.breakAways ?? []) {
      const x = valToPos(time, "x", true);
      if (x < bbox.left || x > bbox.left + bbox.width) continue;
      ctx.beginPath();
      ctx.moveTo(x - size, bbox.top);
      ctx.lineTo(x + size, bbox.top);
      ctx.lineTo(x, bbox.top + 1.6 * size);
      ctx.fill();
    }
    ctx.restore();
  };

  /** Tells the values under the pointer. */
  private readonly tell = (): void => {
    const left = this.plot?.cursor.left ?? -1;
    this.values.hidden = left < 0;
    if (!this.plot || left < 0) return;
    const row = this.plot.posToIdx(left);
    const unit = / in (.*)$/.exec(this.look.up)?.[1] ?? "";
    const texts = this.look.lines.map(({ label }, index) => {
      const value = `${short(this.curves.lines[index][row], 5)} ${unit}`;
      return this.look.lines.length > 1 ? `${label} ${value}` : value;
    });
    this.values.textContent = `${this.curves.times[row].toFixed(3)} s: ${texts.join(", ")}`;
  };

  /** Takes over the range of time that was chosen by dragging. */
  private readonly zoom = (plot: uPlot): void => {
    const { left, width } = plot.select;
    if (width < NARROWEST) return;
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.onZoom?.([plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
  };

  protected data(): uPlot.AlignedData {
    return [this.curves.times, ...this.curves.lines] as unknown as uPlot.AlignedData;
  }

  protected options() {
    // Wherever one of them is above the other.
    const both: [number, number][] = this.look.marked ? [[1, 2], [2, 1]] : [];
    const bands = both.map((series) => ({ series, fill: css("--mark") }));
    const range = (_: uPlot, low: number, high: number) =>
      airy(...extremes([low, high], this.kept?.lines ?? []), this.look.span ?? 1);
    return {
      cursor: {
        y: false,
        drag: { x: this.onZoom !== null, y: false, setScale: false },
        points: { show: false },
        bind: { dblclick: () => () => (this.onZoom?.(null), null) },
      },
      scales: { x: { time: false, range: () => this.range }, y: { range } },
      axes: [axis("Time in s", 34), axis(this.look.up)],
      hooks: { drawClear: [this.shade], draw: [this.point], setCursor: [this.tell], setSelect: [this.zoom] },
      series: [{}, ...this.look.lines.map(stroke)],
      bands,
    } satisfies Omit<uPlot.Options, "width" | "height">;
  }
}

/** One quantity over another: a path, with a gap where a value is NaN and a dot where it is now. */
export class PathChart extends Chart<Paths> {
  private paths: Paths = this.look.lines.map(() => [[], []]);
  private kept: Paths | undefined;

  show(paths: Paths, _: [number, number], kept?: Paths): void {
    this.paths = paths;
    this.kept = kept;
    this.update();
  }

  drawing() {
    const ranges = [0, 1].map((side) => {
      const [low, high] = extremes([null, null], this.paths.map((path) => path[side]));
      return airy(low, high, this.spans[side]);
    });
    return { ranges: ranges as [[number, number], [number, number]], lines: this.paths };
  }

  protected data(): uPlot.AlignedData {
    return [null, ...this.paths] as unknown as uPlot.AlignedData;
  }

  /** The smallest ranges of both axes. */
  private get spans(): [number, number] {
    return [1e-3, this.look.span ?? 1];
  }

  protected options() {
    this.colours = this.look.lines.map((line) => css(line.colour));
    const facets = [
      { scale: "x", auto: true },
      { scale: "y", auto: true },
    ];
    const series = this.look.lines.map((line) => ({ ...stroke(line), facets, paths: this.draw }));
    const range = (side: 0 | 1) => (_: uPlot, low: number, high: number) =>
      airy(...extremes([low, high], this.kept?.map((path) => path[side]) ?? []), this.spans[side]);
    return {
      mode: 2 as const,
      cursor: { show: false },
      scales: { x: { time: false, range: range(0) }, y: { range: range(1) } },
      axes: [axis(this.look.across ?? "", 34), axis(this.look.up)],
      hooks: { drawClear: [this.ghost] },
      series: [{}, ...series],
    } satisfies Omit<uPlot.Options, "width" | "height">;
  }

  private colours: string[] = [];

  /** Draws the run that was kept. */
  private readonly ghost = (plot: uPlot): void =>
    within(plot, (ctx) => {
      ctx.strokeStyle = css("--kept");
      ctx.lineWidth *= 2;
      for (const path of this.kept ?? []) trace(plot, ...path);
    });

  private readonly draw = (plot: uPlot, index: number): null => {
    const [across, up] = this.paths[index - 1];
    if (across.length === 0) return null;
    within(plot, (ctx) => {
      ctx.strokeStyle = ctx.fillStyle = this.colours[index - 1];
      const { dashed, dots, width } = this.look.lines[index - 1];
      const radius = dots === "all" ? dotRadius(width) : 4;
      if (dashed) ctx.setLineDash([5 * devicePixelRatio, 4 * devicePixelRatio]);
      if (dots !== "all") trace(plot, across, up);
      const first = { all: 0, last: across.length - 1, none: across.length }[dots ?? "last"];
      for (let point = first; point < across.length; point += 1) {
        ctx.beginPath();
        ctx.arc(plot.valToPos(across[point], "x", true), plot.valToPos(up[point], "y", true), radius * devicePixelRatio, 0, 2 * Math.PI);
        ctx.fill();
      }
    });
    return null;
  };
}
