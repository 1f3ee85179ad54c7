// Columns of a recording in the units of the charts.

import type { Recording } from "./record";

/** Most points of a drawn line; more do not fit on the pixels. */
const DRAWN = 2500;

/** Interval of drawn rows, from a row whose number is a multiple of it, so that a line does not flicker. */
export function thinning(recording: Recording, first: number, end = recording.rows): (name: string, factor?: number) => Float64Array {
  const stride = Math.max(Math.ceil((end - first) / DRAWN), 1);
  const from = first - (first % stride);
  return (name, factor = 1) => {
    const column = recording.column(name, from, end);
    const count = Math.ceil(column.length / stride);
    const thin = new Float64Array(count);
    for (let index = 0; index < count; index += 1) thin[index] = column[index * stride] * factor;
    return thin;
  };
}

export const MM = 1e3;
export const BAR = 1e-5;
