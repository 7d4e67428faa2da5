// What a plot shows: which of its rows, from where to where, as curves.

import { bounds, extremes, Rows, spaced, whole } from "./rows.js";
import { above, Range } from "./scales.js";

const POINTS = 9000; // of all curves of a plot together
const ORBIT = 5000; // rows of a phase plot

const REPLACED = ["profile", "spectrum"];
export const PLANE = ["phase", "poincare"];

export class Curves {
  view = null; // {x: [low, high], y: [low, high] or null} while zoomed
  paused = false;
  #x = new Range();
  #y = new Range();
  #held = null; // rows that came while the picture stood still
  #end = null; // of appended rows, the number of the last shown then

  constructor(spec) {
    this.spec = spec;
    this.plane = PLANE.includes(spec.kind);
    this.replaced = REPLACED.includes(spec.kind);
    this.x = this.plane ? 1 : 0; // the column of x; in the plane, time stands before it
    this.columns = this.x + 1 + (spec.kind === "time" ? spec.series.length : 1);
    this.rows = new Rows(this.columns);
  }

  get still() {
    return this.paused || this.view !== null;
  }

  // The number of the first row that is not shown any more.
  get end() {
    return Math.min(this.#end ?? this.rows.total, this.rows.total);
  }

  take(values, replace) {
    if (this.replaced && this.still) this.#held = values;
    else if (replace) this.#replace(values);
    else this.rows.append(values);
  }

  #replace(values) {
    this.rows.clear();
    if (!this.replaced && values.length === 0) this.#forget();
    this.rows.append(values);
  }

  // A run that begins anew is shown anew.
  #forget() {
    this.#end = this.still ? 0 : null;
    this.#x.reset();
    this.#y.reset();
  }

  pause(paused) {
    this.paused = paused;
    this.#settle();
  }

  zoom(view) {
    this.view = view;
    this.#settle();
  }

  // Stands still from here on, or shows again what has come.
  #settle() {
    if (this.still) {
      this.#end ??= this.rows.total;
      return;
    }
    this.#end = null;
    if (this.#held) this.#replace(this.#held);
    this.#held = null;
  }

  // Rows from..to (exclusive) that may be seen.
  #seen() {
    const { rows, spec, end: to } = this;
    let from = Math.min(rows.first, to);
    if (spec.kind === "phase") {
      from = Math.max(from, to - ORBIT);
      if (to > from) from = rows.search(rows.at(to - 1, 0) - spec.window, from, to);
    } else if (spec.kind === "time" && !this.view && to > from) {
      from = rows.search(rows.at(to - 1, 0) - spec.window, from, to);
    } else if (!this.plane && this.view) {
      // One row more on either side: the curves go on to the edges.
      const first = rows.search(this.view.x[0], from, to) - 1;
      return [Math.max(first, from), Math.min(rows.search(this.view.x[1], from, to) + 1, to)];
    }
    return [from, to];
  }

  // {x: [low, high], y: [low, high], steps, curves: [Float64Array of x, y, ...]} for a picture of
  // `width` times `height` pixels.
  now(width, height, clock) {
    const [from, to] = this.#seen();
    const x = this.view?.x ?? this.#across(from, to, clock);
    const y = this.view?.y ?? this.#up(from, to, clock);
    const count = this.columns - 1 - this.x;
    const columns = Math.max(Math.min(width, POINTS / count / 2), 40);
    const curves = Array.from({ length: count }, (_, k) =>
      this.#curve(this.x + 1 + k, from, to, x, y, columns, width, height),
    );
    return { x, y, curves };
  }

  #curve(column, from, to, x, y, columns, width, height) {
    if (this.spec.kind === "poincare") return whole(this.rows, this.x, column, from, to);
    if (this.plane) {
      const pixel = [(x[1] - x[0]) / width, (y[1] - y[0]) / height];
      return spaced(this.rows, this.x, column, from, to, ...pixel);
    }
    if (to - from <= 2 * columns) return whole(this.rows, this.x, column, from, to);
    return extremes(this.rows, column, from, to, (x[1] - x[0]) / columns);
  }

  #across(from, to, clock) {
    const { rows, spec } = this;
    if (to <= from) return [0, spec.window || 1];
    if (spec.kind === "time") {
      const last = rows.at(to - 1, 0);
      const begin = Math.max(rows.at(from, 0), last - spec.window);
      // At first a short span that grows in round steps: there is something to see at once.
      return [
        begin,
        begin + Math.min(above(Math.max(last - begin, 0.05 * spec.window)), spec.window),
      ];
    }
    const [low, high] = bounds(rows, this.x, this.x + 1, from, to);
    if (this.replaced) return low < high ? [low, high] : [low - 0.5, low + 0.5];
    this.#x.follow(low, high, clock);
    return this.#x.ends;
  }

  #up(from, to, clock) {
    const [low, high] = bounds(this.rows, this.x + 1, this.columns, from, to);
    const amplitudes = this.spec.kind === "spectrum";
    this.#y.follow(amplitudes ? 0 : low, high, clock);
    return amplitudes ? [0, this.#y.ends[1]] : this.#y.ends;
  }
}
