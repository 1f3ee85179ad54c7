// The best of several starts.

import type { Problem } from "./problem";
import { FINE, refine, ROUGH, type Seen, type Solution } from "./refine";

/** How many of the best starts are refined. */
const REFINED = 3;
/** Starts lie within a factor of five, or within so many magnitudes, of the first. */
const SPREAD = 1.6;
/** Mean square of residuals, in units of the noise, at which no other start can lead to anything better. */
const AT_NOISE = 1.5;
/** Relative difference of costs below which two solutions are taken for the same. */
const SAME = 1e-3;
/** How often sensors and parameters are fitted in turn, and the relative change of the noise that no longer matters. */
const ROUNDS = 4;
const SAME_NOISE = 0.03;

/** Is told what is being done. */
export type Stage = (text: string) => void;

/**
 * Refines the first start; unless it leaves no more than noise, random ones are simulated and the best of them refined,
 * until one leaves no more than noise or two have come to the same end.
 */
export function solve(problem: Problem, starts: number, seen: Seen, stage: Stage): Solution {
  stage("Search from the start that the data tell");
  const solutions = [refine(problem, problem.start, ROUGH, seen)];
  const isEnough = () => {
    if (2 * solutions[solutions.length - 1].cost < AT_NOISE * problem.size) return true;
    const costs = solutions.map(({ cost }) => cost).sort((a, b) => a - b);
    return costs.length > 1 && costs[1] <= (1 + SAME) * costs[0];
  };
  if (starts > 0 && !isEnough()) {
    const rough = problem.with({ tolerance: ROUGH.tolerance });
    const candidates = scattered(problem, starts).map((x, index) => {
      stage(`Start ${index + 1} of ${starts}`);
      return { x, cost: rough.residuals(rough.differences(x)).reduce((total, value) => total + value * value, 0) };
    });
    candidates.sort((a, b) => a.cost - b.cost);
    for (const { x } of candidates.slice(0, REFINED - 1)) {
      stage("Search from one of the best starts");
      solutions.push(refine(problem, x, ROUGH, seen));
      if (isEnough()) break;
    }
  }
  return solutions.sort((a, b) => a.cost - b.cost)[0];
}

/**
 * Weighs the signals by what remains of them, and fits anew, until both agree: a signal that the model misses must not drown
 * the others, and a converter is only known once the rest is.
 */
export function withLikelySensors(given: Problem, best: Solution, seen: Seen, stage: Stage): [Problem, Solution] {
  let problem = given;
  for (let round = 0; round < ROUNDS; round += 1) {
    const before = problem.sensors;
    problem = problem.with({ sensors: problem.likelySensors(best.x) });
    const changes = [...problem.sensors].map(([signal, { noise }]) => Math.abs(Math.log(noise / before.get(signal)!.noise)));
    if (Math.max(...changes) < SAME_NOISE) break;
    stage("Weigh the signals by what is left of them");
    best = refine(problem, best.x, ROUGH, seen);
  }
  stage("Last search");
  return [problem, refine(problem, best.x, FINE, seen)];
}

/** Starts that fill the bounds, or the neighbourhood of the first start, evenly: each parameter has one in each part. */
export function scattered(problem: Problem, number: number): Float64Array[] {
  const random = generator(0);
  const { low, high } = problem.bounds;
  const first = problem.start;
  const found = Array.from({ length: number }, () => first.slice());
  for (let index = 0; index < problem.free.length; index += 1) {
    const least = Math.max(low[index], first[index] - SPREAD);
    const most = Math.min(high[index], first[index] + SPREAD);
    const order = shuffled(number, random);
    found.forEach((x, start) => (x[index] = least + ((order[start] + random()) / number) * (most - least)));
  }
  return found;
}

function shuffled(number: number, random: () => number): number[] {
  const order = Array.from({ length: number }, (_, index) => index);
  for (let index = number - 1; index > 0; index -= 1) {
    const other = Math.floor(random() * (index + 1));
    [order[index], order[other]] = [order[other], order[index]];
  }
  return order;
}

/** Numbers from 0 to 1 that are the same each time (mulberry32). */
function generator(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}
