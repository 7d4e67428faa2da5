// Scales that follow what is drawn without trembling: up at once, down after a while.

import { above, end } from "./numbers.js";

const PATIENCE = 3000;
const ROUNDING = 1e-12; // of its size, by which a constant may seem to move
const TINIEST = 1e-290; // of a range: below, its steps would be short of digits
const [LEAST, MOST] = [2, 12]; // decimals of a time

// Time that passes while something is drawn, in milliseconds; a pause counts as a frame.
class Clock {
  last = null;

  passed(now) {
    const passed = Math.min(now - (this.last ?? now), 100);
    this.last = now;
    return passed;
  }
}

// A round number that the largest value seen stays below; `shown` moves to it smoothly.
export class Scale {
  clock = new Clock();

  constructor() {
    this.reset();
  }

  reset() {
    this.value = this.shown = this.peak = this.quiet = 0;
  }

  follow(largest, now) {
    if (!Number.isFinite(largest)) return this.shown;
    const passed = this.clock.passed(now);
    this.peak = Math.max(this.peak, largest);
    this.quiet += passed;
    if (largest > 0.35 * this.value) this.quiet = this.peak = 0;
    if (largest > this.value) this.value = end(largest);
    else if (this.quiet > PATIENCE && this.peak > 0) this.value = end(this.peak);
    if (this.shown === 0) this.shown = this.value;
    this.shown += (this.value - this.shown) * (1 - Math.exp(-passed / 120));
    if (Math.abs(this.value - this.shown) < 0.01 * this.value) this.shown = this.value;
    return this.shown;
  }

  get moving() {
    return this.shown !== this.value;
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

// A range of round ends about the data: wider at once, narrower once the data have left more than
// a third of it empty for a while.
export class Range {
  clock = new Clock();

  constructor() {
    this.reset();
  }

  reset() {
    this.low = this.high = this.step = NaN;
    this.quiet = 0;
    this.constant = false; // whether the data were, when the ends were chosen
  }

  get ends() {
    return Number.isNaN(this.low) ? [0, 1] : [this.low, this.high];
  }

  follow(low, high, now) {
    if (!(low <= high)) return;
    this.quiet += this.clock.passed(now);
    const inside = this.low <= low && high <= this.high;
    if (high - low > 0.6 * (this.high - this.low) - this.step) this.quiet = 0;
    const moves = this.constant && !constant(low, high);
    if (!inside || moves || this.quiet > PATIENCE) this.#take(low, high);
  }

  #take(low, high) {
    const middle = (low + high) / 2;
    this.constant = constant(low, high);
    // About a constant, a tenth of it; else a little more than the data: no curve is cut where it
    // touches the edge.
    const wanted = this.constant ? Math.abs(middle) / 10 || 1 : 0.515 * (high - low);
    const half = Math.max(wanted, 1e-9 * Math.abs(middle), TINIEST);
    this.step = above(half / 5);
    this.low = Math.floor((middle - half) / this.step + 1e-9) * this.step;
    this.high = Math.ceil((middle + half) / this.step - 1e-9) * this.step;
    this.quiet = 0;
  }
}
