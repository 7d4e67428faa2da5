// Round numbers for axes, and how they are written.

const STEPS = [1, 2, 5, 10];
const ENDS = [1, 1.5, 2, 3, 4, 5, 6, 8, 10];

// The smallest of 1, 2, 5 (or of ENDS) times a power of ten that is not below `least`.
export function above(least, factors = STEPS) {
  if (!(least > 0) || !Number.isFinite(least)) return 1;
  const power = 10 ** Math.floor(Math.log10(least));
  // A hair of room: 0.3 / 0.1 is a bit above 3.
  const factor = factors.find((f) => f * power >= least * (1 - 1e-9)) ?? 10;
  return factor * power;
}

// A round end of a scale that reaches to `least`.
export const end = (least) => above(least, ENDS);

// The multiples of `step` from low to high, as whole numbers of steps.
export function multiples(low, high, step) {
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: Math.max(0, Math.min(last - first + 1, 200)) }, (_, k) => first + k);
}

const power = (size) => Math.floor(Math.log10(size) + 1e-9);
const places = (step) => Math.min(Math.max(0, -power(step)), 20);
const NONE = 1e-6; // of a step: smaller values are zero but for rounding
const tidy = (text) => text.replace("e+", "e").replace("-", "\u2212").replace("e-", "e\u2212");

// A multiple of `step` with the digits that tell it from its neighbours.
export function written(value, step) {
  const large = Math.max(Math.abs(value), step);
  if (large >= 1e6 || step < 1e-4) {
    if (Math.abs(value) < NONE * step) return "0";
    const digits = Math.max(0, power(Math.abs(value)) - power(step));
    return tidy(value.toExponential(Math.min(digits, 15)));
  }
  const text = value.toFixed(places(step));
  return tidy(Number(text) === 0 ? text.replace("-", "") : text);
}

// A number with `digits` significant digits, for legends and hints.
export function short(value, digits = 4) {
  if (!Number.isFinite(value)) return String(value);
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-3)) {
    return tidy(Number(value.toPrecision(digits)).toExponential());
  }
  return tidy(String(Number(value.toPrecision(digits))));
}

// Labels from low to high would be long and all alike: then a number near to them, to be told
// apart from the labels; else 0.
export function base(low, high, step) {
  const size = Math.max(Math.abs(low), Math.abs(high));
  if (!(size / step > 1e5)) return 0;
  const coarse = 100 * above(high - low);
  return Math.round(low / coarse) * coarse;
}
