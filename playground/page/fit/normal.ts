// The normal distribution and Student's.

const ROOT_2 = Math.SQRT2;
/** Where the series gives way to the continued fraction. */
const MIDDLE = 2;

/** erfc(z) e^(z^2) for z from MIDDLE on, by its continued fraction (Abramowitz and Stegun 7.1.14), from behind. */
function scaledTail(z: number): number {
  const terms = z > 6 ? 20 : 90;
  let fraction = z;
  for (let k = terms; k >= 1; k -= 1) fraction = z + k / 2 / fraction;
  return 1 / (Math.sqrt(Math.PI) * fraction);
}

/** erf(z) for smaller z (7.1.6). */
function erf(z: number): number {
  let [term, total] = [z, z];
  for (let k = 1; Math.abs(term) > 1e-17 * Math.abs(total); k += 1) {
    term *= (2 * z * z) / (2 * k + 1);
    total += term;
  }
  return (2 / Math.sqrt(Math.PI)) * Math.exp(-z * z) * total;
}

/** The logarithm of the normal distribution function, with all digits in the tails. */
export function logNormal(x: number): number {
  const z = -x / ROOT_2;
  if (z >= MIDDLE) return Math.log(0.5 * scaledTail(z)) - z * z;
  if (z <= -MIDDLE) return Math.log1p(-0.5 * scaledTail(-z) * Math.exp(-z * z));
  return Math.log(0.5 * (1 - erf(z)));
}

/**
 * Half the width of Student's distribution that holds a probability, for 1 degree of freedom or more
 * (G. W. Hill, Algorithm 396, Communications of the ACM 13, 1970; six digits from three degrees on).
 */
export function student(probability: number, freedom: number): number {
  const p = 1 - probability;
  if (freedom <= 1) return 1 / Math.tan((p * Math.PI) / 2);
  if (freedom <= 2) return Math.sqrt(2 / (p * (2 - p)) - 2);
  const a = 1 / (freedom - 0.5);
  const b = 48 / (a * a);
  let c = (((20700 * a) / b - 98) * a - 16) * a + 96.36;
  const d = ((94.5 / (b + c) - 3) / b + 1) * Math.sqrt((a * Math.PI) / 2) * freedom;
  let x = d * p;
  let y = x ** (2 / freedom);
  if (y > 0.05 + a) {
    x = normalQuantile(0.5 * p);
    y = x * x;
    if (freedom < 5) c += 0.3 * (freedom - 4.5) * (x + 0.6);
    c = (((0.05 * d * x - 5) * x - 7) * x - 2) * x + b + c;
    y = (((((0.4 * y + 6.3) * y + 36) * y + 94.5) / c - y - 3) / b + 1) * x;
    y = Math.expm1(a * y * y);
  } else {
    y = ((1 / (((freedom + 6) / (freedom * y) - 0.089 * d - 0.822) * (freedom + 2) * 3) + 0.5 / (freedom + 4)) * y - 1) *
      ((freedom + 1) / (freedom + 2)) + 1 / y;
  }
  return Math.sqrt(freedom * y);
}

/** The value below which a standard normal one lies with a small probability, by bisection. */
function normalQuantile(probability: number): number {
  let [low, high] = [-40, 40];
  const target = Math.log(probability);
  for (let step = 0; step < 80; step += 1) {
    const middle = 0.5 * (low + high);
    if (logNormal(middle) < target) low = middle;
    else high = middle;
  }
  return 0.5 * (low + high);
}
