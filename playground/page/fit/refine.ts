// Nonlinear least squares: Levenberg and Marquardt's steps within bounds. Jacobians and residuals come from runs, of which
// only the triangle of their QR decomposition is kept: least squares do not change as all residuals are rotated.

import { Matrix } from "ml-matrix";
import { joined } from "./arrays";
import { leastSquares, triangle } from "./matrix";
import { TOLERANCE, type Problem } from "./problem";
import { jacobian } from "./sensitivities";

/** A rough search ends where so many vectors in a row have gained less than this share of the cost together. */
const LOOKED = 8;
const GAINED = 0.02;
/** Vectors that are tried at most. */
const MOST = 80;

/** How exactly a search goes down: relative changes of cost and vector at which it ends, and how exactly it simulates. */
export interface Effort {
  cost: number;
  step: number;
  tolerance: number;
  isCentral: boolean;
  givesUp: boolean;
}

/** For a search that another one continues, and for the last one. */
export const ROUGH: Effort = { cost: 1e-4, step: 1e-5, tolerance: 1e-5, isCentral: false, givesUp: true };
export const FINE: Effort = { cost: 1e-6, step: 1e-8, tolerance: TOLERANCE, isCentral: true, givesUp: false };

export interface Solution {
  x: Float64Array;
  /** Half the sum of the squares. */
  cost: number;
  converged: boolean;
  message: string;
}

/** Is told of each better vector, with the mean square of its residuals in units of the noise. */
export type Seen = (x: Float64Array, meanSquare: number) => void;

/** Goes down from a start. */
export function refine(given: Problem, start: Float64Array, effort: Effort, seen: Seen): Solution {
  const problem = given.with({ tolerance: effort.tolerance });
  const { low, high } = problem.bounds;
  const inside = (x: Float64Array) => x.map((value, index) => Math.min(Math.max(value, low[index]), high[index]));
  const { pull } = problem;
  const at = (x: Float64Array) => {
    const differences = problem.differences(x);
    const ofData = problem.residuals(differences);
    const residuals = joined([ofData, problem.pulls(x)]);
    return { x, differences, residuals, cost: half(residuals), ofData: half(ofData) };
  };
  let now = at(inside(start));
  seen(now.x, (2 * now.ofData) / problem.size);
  let damping = 1e-3;
  let [tried, growth] = [1, 2];
  const scale = new Float64Array(start.length);
  const costs = [now.cost];
  const end = (converged: boolean, message: string): Solution => ({ x: now.x, cost: now.cost, converged, message });
  for (;;) {
    const columns = jacobian(problem, now.x, now.differences, effort.isCentral);
    const slopes = columns.map((column, index) => joined([column, now.x.map((_, row) => (row === index ? pull[row] : 0))]));
    const whole = triangle([...slopes, now.residuals]);
    const count = slopes.length;
    const [square, right] = [whole.subMatrix(0, count - 1, 0, count - 1), whole.subMatrix(0, count - 1, count, count)];
    const gradient = square.transpose().mmul(right).to1DArray();
    for (let index = 0; index < count; index += 1) {
      const norm = Math.hypot(...square.getColumn(index));
      scale[index] = Math.max(scale[index], norm);
    }
    for (let isBetter = false; !isBetter; ) {
      if (tried >= MOST) return end(false, `${MOST} vectors were tried`);
      // What a bound holds does not move out of it.
      const isHeld = now.x.map((value, index) =>
        Number((value <= low[index] && gradient[index] > 0) || (value >= high[index] && gradient[index] < 0)),
      );
      const step = damped(square, right, scale, damping, isHeld);
      const next = inside(now.x.map((value, index) => value + step[index]));
      const moved = next.map((value, index) => value - now.x[index]);
      if (norm(moved) <= effort.step * (effort.step + norm(now.x))) return end(true, "the vector no longer changes");
      const foretold = predicted(square, right, moved);
      const found = at(next);
      tried += 1;
      const gained = now.cost - found.cost;
      costs.push(Math.min(costs[costs.length - 1], found.cost));
      const ratio = foretold > 0 ? gained / foretold : gained > 0 ? 1 : -1;
      const before = now.cost;
      if (gained > 0) {
        now = found;
        seen(now.x, (2 * now.ofData) / problem.size);
        damping *= Math.max(1 / 3, 1 - (2 * ratio - 1) ** 3);
        growth = 2;
        isBetter = true;
      } else {
        damping *= growth;
        growth *= 2;
      }
      if (ratio > 0.25 && gained < effort.cost * before) return end(true, "the cost no longer changes");
      const past = costs[costs.length - 1 - LOOKED];
      if (effort.givesUp && past !== undefined && now.cost > (1 - GAINED) * past) {
        return end(false, `${LOOKED} steps in a row have gained little`);
      }
    }
  }
}

const norm = (values: Float64Array): number => Math.hypot(...values);

function half(values: Float64Array): number {
  let total = 0;
  for (const value of values) total += value * value;
  return 0.5 * total;
}

/** The step that makes |R s + r|^2 + damping |D s|^2 least, without what is held. */
function damped(square: Matrix, right: Matrix, scale: Float64Array, damping: number, isHeld: Float64Array): Float64Array {
  const count = square.columns;
  const stacked = Matrix.zeros(2 * count, count).setSubMatrix(square, 0, 0);
  const side = Matrix.zeros(2 * count, 1).setSubMatrix(right.clone().mul(-1), 0, 0);
  for (let index = 0; index < count; index += 1) {
    stacked.set(count + index, index, Math.sqrt(damping) * (scale[index] || 1));
    if (isHeld[index]) for (let row = 0; row < 2 * count; row += 1) stacked.set(row, index, 0);
  }
  return leastSquares(stacked, side);
}

/** What a step would gain if the residuals were straight. */
function predicted(square: Matrix, right: Matrix, step: Float64Array): number {
  const after = square.mmul(Matrix.columnVector(Array.from(step))).add(right);
  return 0.5 * (right.norm() ** 2 - after.norm() ** 2);
}
