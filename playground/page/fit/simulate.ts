// One run of a model under measured inputs.

import { Refusal, type Library, type Values } from "../library";

/** The slot of the module that the fits run in. */
const SLOT = 0;
/** Steps between two looks at the work that was done. */
const LOOK = 256;
const COUNTED = ["solver.steps", "solver.rejectedSteps"];

export interface Run {
  /** Outputs at the communication points, by name. */
  outputs: Map<string, Float64Array>;
  /** Steps that the solver took, rejected ones included. */
  work: number;
}

/**
 * Makes a run; inputs are held from one communication point to the next. Throws a refusal where the model refuses a value,
 * the solver cannot go on, or it took more than `most` steps. `told` is told the share that is done.
 */
export function simulate(
  library: Library,
  model: string,
  values: Values,
  inputs: ReadonlyMap<string, Float64Array>,
  outputs: readonly string[],
  points: number,
  step: number,
  most: number,
  told: (share: number) => void,
): Run {
  const courses = [...inputs.values()];
  const names = [...inputs.keys()];
  const first = names.map((name, index) => [name, courses[index][0]] as const);
  const plant = library.start(SLOT, model, new Map([...values, ...first]));
  const set = plant.setter(names);
  const read = plant.reader(outputs);
  const count = plant.reader(COUNTED);
  const work = () => count().reduce((total, value) => total + value, 0);
  told(0);
  const found = outputs.map(() => new Float64Array(points));
  const row = new Float64Array(names.length);
  for (let point = 0; ; point += 1) {
    const shown = read();
    for (let index = 0; index < found.length; index += 1) found[index][point] = shown[index];
    if (point === points - 1) break;
    for (let index = 0; index < row.length; index += 1) row[index] = courses[index][point];
    set(row);
    plant.advance((point + 1) * step);
    if (point % LOOK === LOOK - 1) {
      if (work() > most) throw new Refusal(`the solver took more than ${most} steps`);
      told((point + 1) / points);
    }
  }
  return { outputs: new Map(outputs.map((name, index) => [name, found[index]])), work: work() };
}
