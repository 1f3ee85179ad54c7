// Charts over time and of one quantity over another, drawn by uPlot in the colours of the page.

import uPlot from "uplot";
import { element } from "./dom";
import type { Episodes } from "./episodes";
import { short } from "./tables";

export interface Line {
  label: string;
  /** Name of the custom property with its colour. */
  colour: string;
  dashed?: boolean;
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

const HEIGHT = 210;

const probe = element("span", { hidden: true });

/** The colour that a custom property has in the present theme. */
function css(name: string): string {
  if (!probe.isConnected) document.body.append(probe);
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

function axis(label: string): uPlot.Axis {
  return {
    label,
    stroke: css("--muted"),
    grid: { stroke: css("--grid"), width: 1 },
    ticks: { stroke: css("--grid"), width: 1, size: 4 },
    font: "11px system-ui, sans-serif",
    labelFont: "11px system-ui, sans-serif",
    labelSize: 16,
    labelGap: 0,
    size: 46,
    values: (_, splits) => splits.map((value) => short(value, 6)),
  };
}

/** How a line is drawn. */
function stroke(line: Line): uPlot.Series {
  return {
    label: line.label,
    stroke: css(line.colour),
    width: 1.5,
    points: { show: false },
    ...(line.dashed ? { dash: [5, 4] } : {}),
  };
}

/** The keys of what is marked over time. */
const keys = (): HTMLElement[] =>
  [["stick", "sticks"], ["break-away", "breaks away"], ["stop", "end stop"]].map(([name, label]) =>
    element("span", {}, element("span", { class: `patch ${name}` }), label),
  );

/** A chart in the page; it is drawn anew when its width or the colours change. */
export abstract class Chart {
  readonly root: HTMLElement;
  protected plot: uPlot | null = null;
  private readonly holder = element("div", { class: "plot" });

  constructor(protected readonly look: Look) {
    const legend = element("div", { class: "legend" });
    for (const line of look.lines) {
      const key = element("span", { class: line.dashed ? "key dashed" : "key", style: `--line: var(${line.colour})` });
      legend.append(element("span", {}, key, line.label));
    }
    const ofLines = look.lines.length > 1 ? [...legend.children] : [];
    legend.replaceChildren(...ofLines, ...(look.episodes ? keys() : []));
    const title = element("figcaption", {}, element("strong", {}, look.title), legend.children.length ? legend : null);
    this.root = element("figure", { class: "chart", role: "img", "aria-label": look.title }, title, this.holder);
    new ResizeObserver(() => this.fit()).observe(this.holder);
    addEventListener("themechange", () => this.redraw());
  }

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
    if (this.plot) {
      if (this.plot.width !== width) this.plot.setSize({ width, height: HEIGHT });
      return;
    }
    const options = { ...this.options(), width, height: HEIGHT, legend: { show: false } };
    this.plot = new uPlot(options, this.data(), this.holder);
  }
}

/** Lines over time. */
export class TimeChart extends Chart {
  private lines: ArrayLike<number>[] = [[0], ...this.look.lines.map(() => [NaN])];
  private range: [number, number] = [0, 1];
  private episodes: Episodes | null = null;

  /** Shows lines over times, on a given range of time. */
  show(times: ArrayLike<number>, lines: ArrayLike<number>[], range: [number, number], episodes: Episodes | null = null): void {
    this.lines = [times, ...lines];
    this.range = range;
    this.episodes = episodes;
    this.update();
  }

  /** Shades where the carriage sticks or rests against a stop, under grid and lines. */
  private readonly shade = ({ ctx, bbox, valToPos }: uPlot): void => {
    if (!this.episodes) return;
    const fill = (intervals: [number, number][], colour: string) => {
      ctx.fillStyle = css(colour);
      for (const interval of intervals) {
        const [from, to] = interval.map((time) => clamp(valToPos(time, "x", true), bbox.left, bbox.left + bbox.width));
        ctx.fillRect(from, bbox.top, Math.max(to - from, 0), bbox.height);
      }
    };
    ctx.save();
    fill(this.episodes.sticking, "--stick");
    fill(this.episodes.stops, "--stop");
    ctx.restore();
  };

  /** Points down to where the carriage breaks away. */
  private readonly point = ({ ctx, bbox, valToPos }: uPlot): void => {
    if (!this.episodes) return;
    const size = 5 * devicePixelRatio;
    ctx.save();
    ctx.fillStyle = css("--held");
    for (const time of this.episodes.breakAways) {
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

  protected data(): uPlot.AlignedData {
    return this.lines as unknown as uPlot.AlignedData;
  }

  protected options() {
    // Wherever one of them is above the other.
    const both: [number, number][] = this.look.marked ? [[1, 2], [2, 1]] : [];
    const bands = both.map((series) => ({ series, fill: css("--mark") }));
    return {
      cursor: { drag: { x: false, y: false }, points: { show: false } },
      scales: {
        x: { time: false, range: () => this.range },
        y: { range: (_: uPlot, low: number, high: number) => airy(low, high, this.look.span ?? 1) },
      },
      axes: [{ ...axis("Time in s"), size: 34 }, axis(this.look.up)],
      hooks: { drawClear: [this.shade], draw: [this.point] },
      series: [{}, ...this.look.lines.map(stroke)],
      bands,
    } satisfies Omit<uPlot.Options, "width" | "height">;
  }
}

/** One quantity over another: a path, with a gap where a value is NaN and a dot where it is now. */
export class PathChart extends Chart {
  private paths: [ArrayLike<number>, ArrayLike<number>][] = this.look.lines.map(() => [[], []]);

  show(...paths: [ArrayLike<number>, ArrayLike<number>][]): void {
    this.paths = paths;
    this.update();
  }

  protected data(): uPlot.AlignedData {
    return [null, ...this.paths] as unknown as uPlot.AlignedData;
  }

  protected options() {
    this.colours = this.look.lines.map((line) => css(line.colour));
    const facets = [
      { scale: "x", auto: true },
      { scale: "y", auto: true },
    ];
    const series = this.look.lines.map((line) => ({ ...stroke(line), facets, paths: this.draw }));
    const range = (span: number) => (_: uPlot, low: number, high: number) => airy(low, high, span);
    return {
      mode: 2 as const,
      cursor: { show: false },
      scales: { x: { time: false, range: range(1e-3) }, y: { range: range(this.look.span ?? 1) } },
      axes: [{ ...axis(this.look.across ?? ""), size: 34 }, axis(this.look.up)],
      series: [{}, ...series],
    } satisfies Omit<uPlot.Options, "width" | "height">;
  }

  private colours: string[] = [];

  private readonly draw = (plot: uPlot, index: number): null => {
    const [across, up] = this.paths[index - 1];
    if (across.length === 0) return null;
    const { ctx } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(plot.bbox.left, plot.bbox.top, plot.bbox.width, plot.bbox.height);
    ctx.clip();
    ctx.strokeStyle = ctx.fillStyle = this.colours[index - 1];
    ctx.lineWidth = 1.5 * devicePixelRatio;
    ctx.lineJoin = "round";
    const place = (row: number): [number, number] => [
      plot.valToPos(across[row], "x", true),
      plot.valToPos(up[row], "y", true),
    ];
    ctx.beginPath();
    let isGap = true;
    for (let row = 0; row < across.length; row += 1) {
      if (Number.isNaN(across[row])) isGap = true;
      else if (isGap) {
        ctx.moveTo(...place(row));
        isGap = false;
      } else ctx.lineTo(...place(row));
    }
    ctx.stroke();
    ctx.beginPath();
    ctx.arc(...place(across.length - 1), 4 * devicePixelRatio, 0, 2 * Math.PI);
    ctx.fill();
    ctx.restore();
    return null;
  };
}
