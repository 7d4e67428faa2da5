// Round numbers for axes and how they are written, and scales that follow what is drawn without
// trembling: up at once, down after a while.

const STEPS = [1, 2, 5, 10];
const ENDS = [1, 1.5, 2, 3, 4, 5, 6, 8, 10];
const UNLIKE = 6; // times as large a scale, from which on x and y keep their own
const NONE = 1e-6; // of a step: smaller values are zero but for rounding
const PATIENCE = 3000; // milliseconds until a scale that is too large becomes smaller
const ROUNDING = 1e-12; // of its size, by which a constant may seem to move
const TINIEST = 1e-290; // of a range: below, its steps would be short of digits
const [LEAST, MOST] = [2, 12]; // decimals of a time

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

// Numbers at a logarithmic axis, `most` of them at about the most: powers of ten, and 2 and 5 times
// those where there is room; of less than a decade, the multiples of a round step.
export function decades(low, high, most) {
  const count = Math.log10(high / low);
  if (!(count > 1)) {
    const step = above((high - low) / most);
    return multiples(low, high, step).map((times) => times * step);
  }
  const [first, last] = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high))];
  const skip = Math.max(1, Math.ceil(count / most));
  const factors = 3 * count <= most ? [1, 2, 5] : [1];
  const powers = Array.from({ length: Math.floor((last - first) / skip) + 1 }, (_, k) => {
    return Math.ceil(first / skip) * skip + k * skip;
  });
  const ticks = powers.flatMap((power) => factors.map((factor) => factor * 10 ** power));
  return ticks.filter((tick) => low <= tick * (1 + 1e-9) && tick <= high * (1 + 1e-9));
}

// Ends [low, high] of x and y such that both have one scale in a picture of so many pixels, wider
// than they were; as they were where that would make a line of what is shown.
export function alike({ x, y }, { width, height }) {
  const [across, up] = [(x[1] - x[0]) / width, (y[1] - y[0]) / height];
  const most = Math.max(across, up);
  if (!(most < UNLIKE * Math.min(across, up))) return { x, y };
  const about = ([low, high], half) => [(low + high) / 2 - half, (low + high) / 2 + half];
  return { x: about(x, (most * width) / 2), y: about(y, (most * height) / 2) };
}

const power = (size) => Math.floor(Math.log10(size) + 1e-9);

// The power of ten of the last digit of a step: of 0.02 a hundredth, of 0.025 a thousandth.
function finest(step) {
  const first = step / 10 ** power(step);
  return power(step) - (Math.abs(first - Math.round(first)) > 1e-6 ? 1 : 0);
}

const places = (step) => Math.min(Math.max(0, -finest(step)), 20);
const tidy = (text) => text.replace("e+", "e").replace("-", "\u2212").replace("e-", "e\u2212");

// A multiple of `step` with the digits that tell it from its neighbours.
export function written(value, step) {
  const large = Math.max(Math.abs(value), step);
  if (large >= 1e6 || step < 1e-4) {
    if (Math.abs(value) < NONE * step) return "0";
    const digits = Math.max(0, power(Math.abs(value)) - finest(step));
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

// A round number that the largest value seen stays below.
export class Scale {
  #value = 0;
  #peak = 0; // since it was not too large, from a time on, in milliseconds
  #since = 0;

  follow(largest, now) {
    if (!Number.isFinite(largest)) return this.#value;
    this.#peak = Math.max(this.#peak, largest);
    if (largest > 0.35 * this.#value) [this.#since, this.#peak] = [now, 0];
    if (largest > this.#value) this.#value = end(largest);
    else if (now - this.#since > PATIENCE && this.#peak > 0) this.#value = end(this.#peak);
    return this.#value;
  }
}

// A time as text: with so many decimals that a step of it is seen.
export class Written {
  #last = null;
  #decimals = LEAST;

  of(t) {
    const step = Math.abs(t - (this.#last ?? t));
    this.#last = t;
    if (step > 0) {
      const needed = Math.min(Math.max(Math.ceil(-Math.log10(step) - 1e-6), LEAST), MOST);
      // Steps about a power of ten: one decimal too many is let be.
      if (needed !== this.#decimals - 1) this.#decimals = needed;
    }
    return t.toFixed(this.#decimals);
  }
}

const constant = (low, high) =>
  high - low <= ROUNDING * Math.max(Math.abs(low), Math.abs(high));

// A range of round ends about the data, of some size at least: wider at once, narrower once the data
// have left more than a third of it empty for a while.
export class Range {
  constructor(least = 0) {
    this.least = least;
    this.low = this.high = this.step = NaN;
    this.since = NaN; // when they were not too wide, in milliseconds
    this.constant = false; // whether the data were, when the ends were chosen
  }

  get ends() {
    return Number.isNaN(this.low) ? [0, 1] : [this.low, this.high];
  }

  follow(low, high, now) {
    if (!(low <= high)) return;
    const inside = this.low <= low && high <= this.high;
    if (high - low > 0.6 * (this.high - this.low) - this.step) this.since = now;
    const moves = this.constant && !constant(low, high);
    if (inside && !moves && !(now - this.since > PATIENCE)) return;
    this.#take(low, high);
    this.since = now;
  }

  #take(low, high) {
    const middle = (low + high) / 2;
    this.constant = constant(low, high);
    // About a constant, a tenth of it; else a little more than the data: no curve is cut where it
    // touches the edge.
    const wanted = this.constant ? Math.abs(middle) / 10 || 1 : 0.515 * (high - low);
    const half = Math.max(wanted, 1e-9 * Math.abs(middle), this.least, TINIEST);
    this.step = above(half / 5);
    this.low = Math.floor((middle - half) / this.step + 1e-9) * this.step;
    this.high = Math.ceil((middle + half) / this.step - 1e-9) * this.step;
  }
}
