// A start for the parameters of a law, found from the data, as in the Python package.

import { interpolate, joined, line, median, quantile, span } from "./arrays";
import { lawGroup, lawName } from "../tables";
import type { Forces, Values, Window } from "./experiment";
import { at, type Free } from "./free";
import { Motion } from "./motion";
import type { Problem } from "./problem";

/** Share of a static friction that is not free with which sliding friction starts at most. */
const BELOW = 0.8;
/** Elements of the laws that have several. */
const ELEMENTS = 10;
/** Presliding ends within a fiftieth of the stroke, as far as nothing better is known. */
const PRESLIDING = 50;

/** The problem with starts from the data for what the visitor gave no start for. */
export function started(problem: Problem): Problem {
  const values = new Map(problem.free.map(({ name, start }) => [name, start]));
  if (Number.isNaN(values.get("area") ?? 0)) values.set("area", area(problem.windows));
  const add = (found: Values) => found.forEach((value, name) => values.set(name, value));
  add(levels(problem, values));
  if (problem.experiment instanceof Motion) add(elements(problem, values));
  return problem.with({ free: problem.free.map((free) => at(free, values.get(free.name) ?? free.start)) });
}

/** Force over pressure, of all samples: friction has both signs. */
function area(windows: readonly Window[]): number {
  let [both, own] = [0, 1e-300];
  for (const { record, used } of windows) {
    const [pressure, force] = [record.of("pressure"), record.of("force")];
    used.forEach((isUsed, row) => {
      both += isUsed * pressure[row] * force[row];
      own += isUsed * pressure[row] ** 2;
    });
  }
  return both / own;
}

/** Friction levels from a map of mean force against speed. */
function levels(problem: Problem, values: Values): Map<string, number> {
  const { experiment } = problem;
  const group = `${lawGroup(experiment.model, experiment.law)}.`;
  const own = problem.free.filter(({ name }) => name.startsWith(group));
  const maps = problem.windows.flatMap((window) => experiment.forces(window, values) ?? []);
  const found = new Map<string, number>();
  if (!own.length || !maps.length) return found;
  const all = (part: keyof Forces) => joined(maps.map((map) => map[part]));
  const [speed, force, level] = [all("speed"), all("force"), all("level")];
  const fastest = speed.length ? quantile(speed.map(Math.abs), 0.98) : 0;
  const slides = (_: number, row: number) => Math.abs(speed[row]) > 0.1 * fastest && level[row] > 1e-3;
  const pace = speed.map(Math.abs).filter(slides);
  const dry = force.map((value, row) => (value * Math.sign(speed[row])) / level[row]).filter(slides);
  if (fastest === 0 || pace.length < 10) return found;
  let [coulomb, viscous] = dryAndViscous(own, pace, dry, 0.3 * fastest);
  // Sliding friction beyond a static friction that stays as it is would be refused.
  const hasStatic = experiment.model.variables.some(({ name }) => name === `${group}Fs`);
  if (hasStatic && !own.some(({ name }) => name === `${group}Fs`)) {
    coulomb = Math.min(coulomb, BELOW * experiment.value(`${group}Fs`, new Map()));
  }
  const excess = dry.map((value, row) => value - coulomb - viscous * pace[row]);
  const statics = coulomb + Math.min(Math.max(quantile(excess, 0.98), 0.1 * coulomb), 2 * coulomb);
  const length = presliding(problem.windows);
  const law = lawName(experiment.tables, experiment.law);
  const bristles = law === "Bristle" ? experiment.value(`${group}N`, values) : 1;
  const starts: Record<string, number> = {
    Fc: coulomb,
    Fc1: coulomb,
    Fc2: coulomb,
    Fs: statics,
    // Of Armstrong's law it is what static friction has beyond sliding friction.
    FsInf: law === "Armstrong" ? statics - coulomb : statics,
    f1: law === "BlimanSorine" ? 3 * coulomb : 0.6 * coulomb,
    f2: law === "BlimanSorine" ? 2 * coulomb : 3 / length,
    vs: 0.1 * fastest,
    sigma0: law === "Bristle" ? (1.5 * coulomb) / (bristles * length) : coulomb / length,
    k1: (0.3 * coulomb) / length,
    vd: fastest,
    deltaS: length,
    z0: length,
    Delta: length,
    xe: length,
    k: coulomb / length / 4,
    W: coulomb / 4,
  };
  const damping = Math.max(viscous, (0.05 * coulomb) / fastest);
  Object.assign(starts, { sigma2: damping, c1: damping, c2: damping, sigma1: (0.1 * starts.sigma0 * length) / fastest });
  for (const { name } of own) {
    const [kind] = name.slice(name.lastIndexOf(".") + 1).split("[");
    if (name.endsWith("stribeck.FsInf")) found.set(name, 1.2 * statics);
    else if (kind in starts) found.set(name, starts[kind]);
  }
  return found;
}

/** Friction at speed 0 and its growth, from the faster samples; no growth under a law without a free one. */
function dryAndViscous(own: readonly Free[], pace: Float64Array, dry: Float64Array, least: number): [number, number] {
  const middle = Math.max(median(dry), 1e-9);
  const isFast = (_: number, row: number) => pace[row] > least;
  const fast = pace.filter(isFast);
  if (!own.some(({ unit }) => unit === "N.s/m") || fast.length < 10) return [middle, 0];
  const [slope, coulomb] = line(fast, dry.filter(isFast));
  return slope <= 0 || coulomb < 0.1 * middle ? [middle, 0] : [coulomb, slope];
}

/** Presliding length in m. */
function presliding(windows: readonly Window[]): number {
  const strokes = windows.flatMap(({ record }) => record.signals.get("position") ?? []).map(span);
  return Math.max((strokes.length ? Math.max(...strokes) : 1e-3) / PRESLIDING, 1e-7);
}

/** Stiffnesses of parallel elements by non-negative least squares, with fixed deflections at which they slip. */
function elements(problem: Problem, values: Values): Map<string, number> {
  const { experiment, windows } = problem;
  const law = lawName(experiment.tables, experiment.law);
  const found = new Map<string, number>();
  if (!["MaxwellSlip", "GMS", "Leuven", "DNLRX"].includes(law)) return found;
  const group = `${lawGroup(experiment.model, experiment.law)}.`;
  const number = law === "Leuven" ? ELEMENTS : experiment.value(`${group}N`, values);
  const stroke = Math.max(...windows.map(({ driven }) => span(driven.get("position")!)));
  // Deflections at which elements slip are spread over the stroke on a logarithmic scale.
  const ends = Array.from({ length: number }, (_, index) => stroke * 100 ** (number > 1 ? index / (number - 1) - 1 : -1));
  const [signal] = experiment.compared;
  const { stiffness, offset } = springs(problem, ends, new Map([...values, [`offset.${signal}`, 0]]));
  found.set(`offset.${signal}`, offset);
  // An element that the data do not need keeps a little stiffness, since a logarithm is free.
  const least = 1e-4 * Math.max(...stiffness, 1);
  const stiff = stiffness.map((value) => Math.max(value, least));
  const limits = stiff.map((value, index) => value * ends[index]);
  const total = limits.reduce((all, limit) => all + limit, 0);
  const set = (name: string, value: number) => found.set(`${group}${name}`, value);
  if (law === "Leuven") {
    // A presliding nearly as straight as that of the elements, which ends about as sharply as they slip.
    const whole = stiff.reduce((all, value) => all + value, 0);
    const starts = { k1: whole, f1: 0.05 * total, f2: 1 / ends[ends.length - 1], Fs: 1.02 * total, Fc: total, n: 5 };
    for (const [name, value] of Object.entries(starts)) set(name, value);
    return found;
  }
  // The shares of GMS belong to its level, where that is not free.
  const isFree = problem.free.some(({ name }) => name === `${group}Fc`);
  const level = isFree || law !== "GMS" ? total : experiment.value(`${group}Fc`, new Map());
  stiff.forEach((value, index) => {
    const place = `[${index + 1}]`;
    set(`k${place}`, value);
    set(`chi0${place}`, value);
    set(`W${place}`, limits[index]);
    set(`limit${place}`, ends[index]);
    set(`alpha${place}`, limits[index] / level);
  });
  if (law === "GMS") {
    set("Fc", level);
    set("Fs", 1.02 * level);
  }
  return found;
}

/** The stiffnesses in N/m of elements that slip at deflections, and the constant force beside them. */
function springs(problem: Problem, ends: number[], values: Values): { stiffness: number[]; offset: number } {
  const columns = [...ends.map(() => [] as Float64Array[]), [] as Float64Array[], [] as Float64Array[]];
  const forces: Float64Array[] = [];
  for (const window of problem.windows) {
    const { force, level } = (problem.experiment as Motion).forces(window, values);
    const isFitted = (_: number, row: number) => window.used[row] === 1 && window.held[row] === 0;
    ends.forEach((end, index) => {
      const own = interpolate(window.record.time, window.record.grid, deflection(window.driven.get("position")!, end));
      columns[index].push(own.filter(isFitted).map((value, row) => value * level[row]));
    });
    columns[ends.length].push(level.map(() => 1));
    columns[ends.length + 1].push(level.map(() => -1));
    forces.push(force);
  }
  const found = nonNegative(columns.map(joined), joined(forces));
  return { stiffness: found.slice(0, ends.length), offset: found[ends.length] - found[ends.length + 1] };
}

/** The deflection of an element that slips at an end. */
function deflection(position: Float64Array, end: number): Float64Array {
  let deflected = 0;
  return position.map((place, point) => {
    const moved = point ? place - position[point - 1] : 0;
    return (deflected = Math.min(Math.max(deflected + moved, -end), end));
  });
}

/** Least squares with factors that are not negative, one factor after the other until none changes. */
export function nonNegative(columns: Float64Array[], right: Float64Array): number[] {
  const product = (a: Float64Array, b: Float64Array) => a.reduce((total, value, row) => total + value * b[row], 0);
  const squares = columns.map((one) => columns.map((other) => product(one, other)));
  const found = columns.map(() => 0);
  const slope = columns.map((column) => -product(column, right));
  for (let turn = 0; turn < 10_000; turn += 1) {
    let most = 0;
    for (let index = 0; index < found.length; index += 1) {
      if (squares[index][index] === 0) continue;
      const next = Math.max(found[index] - slope[index] / squares[index][index], 0);
      const change = next - found[index];
      if (change === 0) continue;
      found[index] = next;
      for (let other = 0; other < slope.length; other += 1) slope[other] += change * squares[other][index];
      most = Math.max(most, Math.abs(change) / Math.max(next, 1e-300));
    }
    if (most < 1e-9) break;
  }
  return found;
}
