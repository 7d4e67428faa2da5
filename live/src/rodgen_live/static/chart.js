// One picture by uPlot: curves between given ends, and the place that is looked at.

import { PLANE } from "./curves.js";
import { make } from "./dom.js";
import { dots, straight, trace } from "./paths.js";
import { outlined } from "./rod_marks.js";
import { nearest } from "./rows.js";
import { alike, base, decades, short, written } from "./scales.js";
import { classes, theme } from "./theme.js";
import { uPlot } from "./uplot.js";

export const MANY = 8; // series from which on they are coloured along a colour map
const FONT = "px Roboto, system-ui, sans-serif";
const NEAR = 30; // pixels from a curve in the plane that still tell its value
const LEAST = 8; // pixels that a drag must span
const [LINEAR, LOGARITHMIC] = [1, 3]; // as uPlot counts them
const [DOT, RING, PRESENT] = [3, 5, 8]; // pixels across
const [DASH, PALE] = [[5, 4], 0.75]; // of the run that is kept

export function colours(spec) {
  const { series, along } = theme();
  const count = spec.series.length;
  return count > MANY ? classes(along, count) : series.slice(0, count);
}

export const axisName = ({ label, unit }) => (unit ? `${label} [${unit}]` : label);

// What the key says of a curve; its unit where the curves do not share that of the axis.
export const entry = ({ y }, { name, label, unit }) =>
  axisName({ label: label ?? name, unit: y.unit ? "" : unit });

export class Chart {
  // What Curves.now gives, and `marks`: values of x, and words for each.
  shown = { x: [0, 1], y: [0, 1], times: null, across: [], up: [], marks: [] };
  found = null; // the row that is looked at, counted among those shown
  led = false; // whether the pointer is over the picture: then no other place is looked at in it
  #from = [0, 0]; // what the numbers at the axes are counted from
  time = null; // that is looked at elsewhere
  #dense; // pixels of the picture for one of the page

  // `on`: zoom(view) when a part was chosen, looked(time or null) when the pointer is at another.
  constructor(box, spec, on = {}, size = [box.clientWidth, box.clientHeight], dense = 1) {
    Object.assign(this, { box, spec, on, size });
    this.#dense = dense;
    this.plane = PLANE.includes(spec.kind);
    const options = this.#options();
    this.plot = new uPlot(options, options.series.map(() => [[], []]), box);
  }

  #options() {
    const [width, height] = this.size.map((pixels) => Math.max(pixels, 100) * this.#dense);
    const drag = { x: true, y: this.plane, setScale: false, dist: LEAST };
    return {
      mode: 2, // each curve has its own x
      width,
      height,
      padding: [10 * this.#dense, 14 * this.#dense, 0, 0],
      legend: { show: false },
      scales: { x: this.#scale("x"), y: this.#scale("y") },
      axes: [this.#axis(0, this.spec.x, 52, 18), this.#axis(1, this.spec.y, 26, 58)],
      series: [null, ...this.#series()],
      cursor: {
        y: this.plane,
        drag,
        dataIdx: (_, k) => this.#index(k),
        points: { size: 8, width: 2, fill: "transparent", stroke: (_, k) => colours(this.spec)[k - 1] },
        bind: {
          dblclick: () => () => this.on.zoom(null),
          mousemove: (_, on, move) => (event) => {
            if (event.target !== on) return;
            Object.assign(this, { led: true, time: null });
            move(event);
          },
          mouseleave: (_, on, leave) => (event) => {
            this.led = false;
            leave(event);
          },
        },
      },
      hooks: {
        setCursor: [() => this.#pointed()],
        setSelect: [() => this.#selected()],
        draw: [() => this.#mark()],
      },
    };
  }

  #scale(k) {
    const distr = this.spec[k].log ? LOGARITHMIC : LINEAR;
    return { time: false, distr, range: () => this.shown[k] };
  }

  #axis(k, quantity, space, size) {
    const dense = this.#dense;
    const line = (colour) => ({ stroke: () => theme()[colour], width: dense });
    return {
      stroke: () => theme().ink,
      font: 11 * dense + FONT,
      labelFont: 11 * dense + FONT,
      space: space * dense,
      size: size * dense,
      gap: 4 * dense,
      labelSize: 18 * dense,
      ticks: { show: false },
      grid: line("grid"),
      border: { ...line("axis"), show: true },
      label: axisName(quantity),
      ...(quantity.log ? this.#powers(space) : this.#numbers(k, quantity)),
    };
  }

  // Numbers at an axis, counted from what they all begin with, which its name says.
  #numbers(k, quantity) {
    const label = () => {
      const { series, x } = this.spec;
      const from = this.#from[k] ? ` from ${short(this.#from[k], 15)}` : "";
      const less = this.shown.turned && (k ? series : [x]).some(({ turn }) => turn);
      const label = quantity.label + from + (less ? " less whole turns" : "");
      return axisName({ ...quantity, label });
    };
    const values = (_, splits, axis, found, step) => {
      this.#from[k] = base(...this.shown[k ? "y" : "x"], step);
      return splits.map((value) => written(value - this.#from[k], step));
    };
    return { label, values };
  }

  #powers(space) {
    return {
      splits: (u, k, low, high) => {
        const pixels = k ? u.over.clientHeight : u.over.clientWidth;
        return decades(low, high, Math.max(pixels / space, 2));
      },
      filter: (_, splits) => splits,
      values: (_, splits) => splits.map((value) => short(value, 6)),
    };
  }

  // The curves, those of the run that is kept, and where the curve of a phase plot is now.
  #series() {
    const { kind, series, x } = this.spec;
    const dense = this.#dense;
    const width = (series.length > MANY ? 1 : 1.6) * dense;
    const shade = (k) => () => colours(this.spec)[k];
    const dash = DASH.map((pixels) => pixels * dense);
    const dot = (size, fill) => {
      return { auto: false, width, stroke: null, fill, paths: dots(size * dense * devicePixelRatio) };
    };
    const curve = (one, k) => {
      if (kind === "poincare") return dot(DOT, shade(k));
      const paths = (...asked) => {
        const leaps = ["phase", "sweep"].includes(kind) || (kind === "time" && one.period);
        return (leaps ? trace(x.period, one.period) : straight)(...asked);
      };
      return { auto: false, width, stroke: shade(k), paths, dash: one.dashed ? dash : [] };
    };
    const ring = { fill: null, paths: dots(RING * dense * devicePixelRatio, true) };
    const pale = (of, k) => {
      const look = kind === "poincare" ? { ...ring, stroke: shade(k) } : { dash };
      return { ...curve(of, k), ...look, alpha: PALE };
    };
    const present = kind === "phase" ? [dot(PRESENT, () => theme().present)] : [];
    return [...series.map(curve), ...series.map(pale), ...present];
  }

  draw(shown) {
    const { spec, plot } = this;
    // Quantities of one unit, one over the other, have one scale.
    const one = this.plane && spec.x.unit === spec.y.unit;
    this.shown = one ? { ...shown, ...alike(shown, plot.bbox) } : shown;
    const { across, up, ghost } = shown;
    const data = [null, ...up.map((values) => [across, values])];
    data.push(...ghost.up.map((values) => [ghost.across, values]));
    if (spec.kind === "phase") data.push([across.slice(-1), up[0].slice(-1)]);
    plot.batch(() => plot.setData(data));
    if (this.time !== null) this.look(this.time);
  }

  // Lines at values of x, with words at their tops, one below the other.
  #mark() {
    const { ctx, bbox } = this.plot;
    const [low, high] = this.shown.x;
    ctx.save();
    ctx.strokeStyle = theme().kick;
    ctx.globalAlpha = 0.6;
    ctx.setLineDash([4, 4].map((pixels) => pixels * this.#dense));
    ctx.beginPath();
    const places = this.shown.marks
      .filter(([value]) => value >= low && value <= high)
      .map(([value, words]) => [Math.round(this.plot.valToPos(value, "x", true)) + 0.5, words]);
    for (const [x] of places) {
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
    }
    ctx.stroke();
    const pixel = this.#dense * devicePixelRatio;
    ctx.scale(pixel, pixel);
    ctx.setLineDash([]);
    Object.assign(ctx, { globalAlpha: 1, font: 11 + FONT, fillStyle: theme().ink });
    for (const [row, [x, words]] of places.entries()) {
      const left = x > bbox.left + bbox.width / 2;
      ctx.textAlign = left ? "right" : "left";
      outlined(ctx, words, x / pixel + (left ? -4 : 4), bbox.top / pixel + 12 + 14 * row, theme());
    }
    ctx.restore();
  }

  // The time `t` is looked at elsewhere; null: nowhere.
  look(t) {
    if (this.led) return;
    this.time = t;
    const { times, across, up, x } = this.shown;
    if (!times) return;
    this.found = t === null || !times.length ? null : nearest(times, t);
    const { found, plot } = this;
    const seen = found !== null && x[0] <= across[found] && across[found] <= x[1];
    const left = seen ? plot.valToPos(across[found], "x") : -10;
    plot.setCursor({ left, top: seen ? plot.valToPos(up[0][found], "y") : -10 }, false);
    if (!seen) this.found = null;
  }

  // uPlot asks for the row under the cursor, curve by curve.
  #index(k) {
    if (k === 1 && this.time === null) this.found = this.#under(this.plot.cursor);
    const { up } = this.shown;
    return Number.isFinite(up[k - 1]?.[this.found]) ? this.found : null;
  }

  #under({ left, top }) {
    const { across, up } = this.shown;
    if (!across.length) return null;
    const back = (x, row) => row && x < across[row - 1];
    const turns = this.spec.kind === "sweep" && across.some(back); // as branches do at folds
    if (!this.plane && !turns) return nearest(across, this.plot.posToVal(left, "x"));
    let [best, least] = [null, turns ? Infinity : NEAR];
    for (let row = 0; row < across.length; row++) {
      const height = up.find((values) => Number.isFinite(values[row])) ?? up[0];
      const [x, y] = this.place(across[row], height[row]);
      const distance = Math.hypot(x - left, y - top);
      if (distance < least) [best, least] = [row, distance];
    }
    return best;
  }

  #pointed() {
    if (this.time !== null) return;
    if (this.plot.cursor.left < 0) this.found = null;
    this.on.looked?.(this.found === null ? null : (this.shown.times?.[this.found] ?? null));
  }

  #selected() {
    const { left, top, width, height } = this.plot.select;
    if (!(width >= LEAST)) return;
    const [x0, y1] = this.value(left, top);
    const [x1, y0] = this.value(left + width, top + height);
    this.plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.on.zoom({ x: [x0, x1], y: this.plane ? [y0, y1] : null });
  }

  // Pixels within the axes to coordinates, and back.
  value(left, top) {
    return [this.plot.posToVal(left, "x"), this.plot.posToVal(top, "y")];
  }

  place(x, y) {
    return [this.plot.valToPos(x, "x"), this.plot.valToPos(y, "y")];
  }

  // The picture at twice its size: a canvas.
  async picture() {
    const twice = new Chart(make("div"), this.spec, {}, this.size, 2);
    await null; // uPlot draws after the script that has made it
    twice.draw(this.shown);
    return twice.plot.ctx.canvas;
  }

  resize() {
    const [width, height] = (this.size = [this.box.clientWidth, this.box.clientHeight]);
    this.plot.setSize({ width, height });
  }

  dispose() {
    this.plot.destroy();
  }
}
