// Statistics of arrays.

export const sum = (values: ArrayLike<number>): number => {
  let total = 0;
  for (let index = 0; index < values.length; index += 1) total += values[index];
  return total;
};

export const mean = (values: ArrayLike<number>): number => sum(values) / values.length;

/** The value below which a share of the values lies, on straight lines between them. */
export function quantile(values: ArrayLike<number>, share: number): number {
  const sorted = Float64Array.from(values).sort();
  const place = share * (sorted.length - 1);
  const low = Math.floor(place);
  const high = Math.min(low + 1, sorted.length - 1);
  return sorted[low] + (place - low) * (sorted[high] - sorted[low]);
}

export const median = (values: ArrayLike<number>): number => quantile(values, 0.5);

export function extremes(values: ArrayLike<number>): [number, number] {
  let [least, most] = [Infinity, -Infinity];
  for (let index = 0; index < values.length; index += 1) {
    if (values[index] < least) least = values[index];
    if (values[index] > most) most = values[index];
  }
  return [least, most];
}

/** Largest less smallest value. */
export function span(values: ArrayLike<number>): number {
  const [least, most] = extremes(values);
  return most - least;
}

/** The differences of neighbours. */
export function differences(values: ArrayLike<number>): Float64Array {
  const found = new Float64Array(Math.max(values.length - 1, 0));
  for (let index = 0; index < found.length; index += 1) found[index] = values[index + 1] - values[index];
  return found;
}

/** The slope and the value at 0 of the straight line through points, by least squares. */
export function line(across: ArrayLike<number>, up: ArrayLike<number>): [number, number] {
  const [x, y] = [mean(across), mean(up)];
  let [both, own] = [0, 0];
  for (let index = 0; index < across.length; index += 1) {
    both += (across[index] - x) * (up[index] - y);
    own += (across[index] - x) ** 2;
  }
  return [both / own, y - (both / own) * x];
}

/** Values on straight lines through points whose places rise, held beyond the ends; `places` rise, too. */
export function interpolate(places: ArrayLike<number>, across: ArrayLike<number>, up: ArrayLike<number>): Float64Array {
  const found = new Float64Array(places.length);
  const last = across.length - 1;
  let at = 0;
  for (let index = 0; index < places.length; index += 1) {
    const place = places[index];
    while (at < last && across[at + 1] <= place) at += 1;
    if (at === last || place <= across[0]) found[index] = up[at === last ? last : 0];
    else found[index] = up[at] + ((up[at + 1] - up[at]) * (place - across[at])) / (across[at + 1] - across[at]);
  }
  return found;
}

/** Arrays one after the other. */
export function joined(parts: readonly Float64Array[]): Float64Array {
  const all = new Float64Array(parts.reduce((length, part) => length + part.length, 0));
  let first = 0;
  for (const part of parts) {
    all.set(part, first);
    first += part.length;
  }
  return all;
}

/** The standard deviation of all values of some courses together. */
export function deviation(courses: readonly Float64Array[]): number {
  const number = courses.reduce((total, { length }) => total + length, 0);
  const mean = courses.reduce((total, values) => total + values.reduce((sum, value) => sum + value, 0), 0) / number;
  return Math.sqrt(courses.reduce((total, values) => total + values.reduce((sum, value) => sum + (value - mean) ** 2, 0), 0) / number);
}
