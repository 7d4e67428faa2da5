// What a plot shows: which of its rows, from where to where.

import { bounds, folded, mean, Rows } from "./rows.js";
import { above, Range } from "./scales.js";

const ORBIT = 5000; // rows of a phase plot

const AWAY = 0.75; // turns that the mean of a curve may be away from those taken off, before others are
const DEEPEST = 1e-9; // of the largest amplitude, below which a logarithmic axis shows none
const REPLACED = ["profile", "spectrum", "sweep"];
export const PLANE = ["phase", "poincare"];

export class Curves {
  view = null; // {x: [low, high], y: [low, high] or null} while zoomed
  paused = false;
  former = false; // whether the run that it shows, paused, has been followed by another
  #x;
  #y;
  #until = null; // the end of what is seen where a time of the past is looked at
  #turns = { x: null, y: null }; // whole turns that are taken off the curves, null: not known yet
  #end = null; // of rows that are appended, the number of the last shown while the picture stands

  constructor(spec) {
    this.spec = spec;
    this.wrapped = spec.wrapped;
    this.#refit();
    this.plane = PLANE.includes(spec.kind);
    this.replaced = REPLACED.includes(spec.kind);
    this.x = this.plane ? 1 : 0; // the column of x; in the plane, time stands before it
    this.columns = this.x + 1 + spec.series.length;
    this.rows = this.shown = new Rows(this.columns); // not the same while the picture stands
    this.ghost = new Rows(this.columns);
  }

  // The number of the first row that is not shown any more.
  get end() {
    return Math.min(this.#end ?? this.shown.total, this.shown.total);
  }

  take(values, replace) {
    if (replace) this.rows = new Rows(this.columns);
    this.rows.append(values);
    if (!this.paused) this.shown = this.rows;
  }

  // The run has begun anew, and is shown so; one that is paused keeps the run before.
  restart() {
    if (this.spec.kind === "sweep") return; // it is of no run
    this.rows = new Rows(this.columns);
    if (this.paused) this.former = this.shown.length > 0;
    else this.#follow();
  }

  pause(paused) {
    this.paused = paused;
    if (paused) this.#end = this.shown.total;
    else this.#follow();
  }

  wrap(wrapped) {
    this.wrapped = wrapped;
    this.#turns = { x: null, y: null };
    this.#refit();
  }

  #refit() {
    [this.#x, this.#y] = [this.spec.x, this.spec.y].map(({ least }) => new Range(least));
  }

  #follow() {
    this.#end = null;
    this.former = false;
    if (this.shown !== this.rows) this.#refit();
    this.shown = this.rows;
  }

  // Rows of the run that is kept, as those of the plot; none: no such run.
  compare(values) {
    if (this.replaced && this.paused && values.length) return; // they are of the present
    this.ghost = new Rows(this.columns);
    this.ghost.append(values);
  }

  // Has a time of the past in the picture, in the plane as the end of it; null: the present. True
  // where that is another picture.
  turn(t) {
    const before = this.#until;
    if (this.replaced || t === null || this.shown.length === 0) this.#until = null;
    else this.#until = this.plane ? t : this.#turned(t, this.shown.at(this.end - 1, 0));
    return this.#until !== before;
  }

  // The end of a window with t in it: that which is there, as long as it has it.
  #turned(t, last) {
    const { window } = this.spec;
    const until = Math.min(this.#until ?? last, last);
    return t <= until && t >= until - window ? until : Math.min(t + window / 2, last);
  }

  // Rows from..to (exclusive) that may be seen.
  #seen() {
    const { shown: rows, spec } = this;
    let to = this.end;
    if (this.#until !== null && (this.plane || !this.view)) {
      const end = to;
      to = rows.search(this.#until, rows.first, end);
      while (to < end && rows.at(to, 0) <= this.#until) to += 1; // of two at one time, both
    }
    let from = Math.min(rows.first, to);
    const lasts = spec.kind === "phase" || (spec.kind === "time" && !this.view);
    if (spec.kind === "phase") from = Math.max(from, to - ORBIT);
    if (lasts && to > from) from = rows.search(rows.at(to - 1, 0) - spec.window, from, to);
    if (this.plane || !this.view) return [from, to];
    // One row more on either side: the curves go on to the edges.
    const first = rows.search(this.view.x[0], from, to) - 1;
    return [Math.max(first, from), Math.min(rows.search(this.view.x[1], from, to) + 1, to)];
  }

  // {x: [low, high], y: [low, high], times, across, up: [values, ...], turned, ghost: {across, up}};
  // times: of each row, null where rows are not of different times; turned: whether whole turns
  // are left out.
  now(clock) {
    const [from, to] = this.#seen();
    const { across, up, turned } = this.#columns(this.shown, from, to);
    const times = this.replaced ? null : this.shown.column(0, from, to);
    const when = this.#when(times);
    let ghost = when && this.#beside(when);
    const x = this.view?.x ?? this.#across(across, ghost?.across, clock);
    ghost ??= this.#beside(x);
    const y = this.view?.y ?? this.#up([...up, ...ghost.up], clock);
    return { x, y, times, across, up, turned: turned || ghost.turned, ghost };
  }

  // What is drawn of rows from..to: views of them, but for angles that are shown without their
  // whole turns: those of each point, or those of the mean of the curves.
  #columns(rows, from, to) {
    const [across, ...up] = rows.data.map((_, k) => rows.column(k, from, to)).slice(this.x);
    if (!this.wrapped) return { across, up, turned: false };
    const { x, series } = this.spec;
    const leads = rows !== this.ghost;
    const found = {
      across: this.#fold("x", [across], [x], leads)[0],
      up: this.#fold("y", up, series, leads),
    };
    const turned = found.across !== across || found.up.some((values, k) => values !== up[k]);
    return { ...found, turned };
  }

  // leads: whether turns are those of these columns, else of those before.
  #fold(axis, columns, quantities, leads) {
    const turned = columns.filter((_, k) => quantities[k].turn);
    if (!turned[0]?.length) return columns;
    const { turn } = quantities.find((one) => one.turn);
    if (this.spec.kind === "poincare") return columns.map((values) => folded(values, turn));
    const away = mean(turned) / turn;
    const before = this.#turns[axis];
    const known = before !== null && Math.abs(away - before) <= AWAY;
    if (leads && !known) this.#turns[axis] = Math.round(away);
    const whole = turn * this.#turns[axis];
    if (!whole) return columns;
    return columns.map((values, k) => (quantities[k].turn ? values.map((one) => one - whole) : values));
  }

  // From when to when the run that is kept is in the picture; null: that is the axis of x.
  #when(times) {
    const { kind } = this.spec;
    if (kind === "time") return null;
    if (kind === "phase" && times.length) return [times[0], times.at(-1)];
    return [-Infinity, this.plane ? (this.#until ?? Infinity) : Infinity];
  }

  // What is drawn of the run that is kept, between two times.
  #beside([begin, end]) {
    const { ghost } = this;
    const last = ghost.total;
    const from = Math.max(ghost.search(begin, ghost.first, last) - 1, ghost.first);
    const to = Math.min(ghost.search(end, ghost.first, last) + 1, last);
    return this.#columns(ghost, from, to);
  }

  #across(values, beside, clock) {
    const { spec } = this;
    if (!values.length && !beside?.length) return [spec.x.log ? 0.1 : 0, spec.window || 1];
    if (spec.kind === "time") {
      const last = values.at(-1);
      const begin = Math.max(values[0], last - spec.window);
      // At first a short span that grows in round steps: there is something to see at once.
      const span = above(Math.max(last - begin, 0.05 * spec.window));
      return [begin, begin + Math.min(span, spec.window)];
    }
    // On a logarithmic axis there is no place for a frequency of zero.
    const columns = [values, beside ?? values].map((some) => (spec.x.log ? some.subarray(1) : some));
    const [low, high] = bounds(columns);
    if (this.replaced) return low < high ? [low, high] : [low - 0.5, low + 0.5];
    this.#x.follow(low, high, clock);
    return this.#x.ends;
  }

  #up(columns, clock) {
    const [low, high] = bounds(columns);
    if (this.spec.y.log) {
      this.#y.follow(...[Math.max(low, DEEPEST * high), high].map(Math.log10), clock);
      return this.#y.ends.map((end) => 10 ** end);
    }
    const amplitudes = this.spec.kind === "spectrum";
    this.#y.follow(amplitudes ? 0 : low, high, clock);
    return amplitudes ? [0, this.#y.ends[1]] : this.#y.ends;
  }
}
