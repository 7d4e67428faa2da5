// The rod as it is now, drawn on a canvas.

import { around, Camera, fitted } from "./camera.js";
import { anchors, support } from "./rod_anchors.js";
import { enlarged } from "./rod_enlarged.js";
import { grid } from "./rod_grid.js";
import { hint, met, said } from "./rod_hint.js";
import { ghost, over, twice } from "./rod_ghost.js";
import { joints, length, Links } from "./rod_links.js";
import { Loads, most } from "./rod_loads.js";
import {
  arrows,
  axes,
  bodies,
  centre,
  ends,
  frame,
  legend,
  outlined,
} from "./rod_marks.js";
import { swing } from "./rod_modes.js";
import { pull } from "./rod_pull.js";
import { Reach } from "./rod_reach.js";
import { Scale, short } from "./scales.js";
import { theme } from "./theme.js";

// A drawing that is kept, and made anew only where what it depends on has changed.
class Layer {
  #canvas = document.createElement("canvas");
  #key = null;

  // Puts a drawing of width times height pixels at (x, y). `paint` makes it, from its own corner
  // (0, 0); `key` is a text of all that it depends on.
  put(context, dense, [x, y, width, height], key, paint) {
    const full = `${key}/${width}/${height}/${dense}`;
    if (this.#key !== full) {
      this.#key = full;
      Object.assign(this.#canvas, {
        width: Math.ceil(width * dense),
        height: Math.ceil(height * dense),
      });
      const own = this.#canvas.getContext("2d");
      own.scale(dense, dense);
      own.font = context.font;
      paint(own);
    }
    context.drawImage(this.#canvas, x, y, this.#canvas.width / dense, this.#canvas.height / dense);
  }
}

const FONT = "12px Roboto, system-ui, sans-serif";
const DENSEST = 2; // device pixels per pixel that are drawn at most
const SAME = 1e-3; // of its length, by which a rod may differ that is fitted

export class Picture {
  camera = new Camera();
  points = new Float64Array(0); // joints in pixels
  kick = null; // {link, share, dx, dy}, in pixels, while it is drawn
  hand = null; // {link, share, x, y}, in pixels, while the pointer pulls
  options = {
    show: {},
    loads: [],
    bodies: [],
    ties: [],
    bed: [],
    view: "fixed",
    support: "none",
    clampAngle: 0,
    perMetre: 0,
    times: 1,
    mode: null,
  };
  #pointed = null; // [x, y] of a pointer that rests, in pixels
  #grid = new Layer();
  #key = new Layer();
  #links = new Links();
  #loads = new Loads();
  #moments = new Scale();
  #reach = new Reach();
  settled = false; // what is shown was fitted to this rod, or chosen since
  chosen = false; // by who looks: another size of the picture leaves it alone
  #restless = false;
  #fitted = { begun: 0, length: 0 }; // what was fitted last
  #two = false; // whether the run that is kept stands beside

  constructor(canvas, state) {
    this.canvas = canvas;
    this.state = state;
    this.context = canvas.getContext("2d", { alpha: false });
  }

  // A pointer rests at a place [x, y], or null: nowhere.
  point(place) {
    this.#pointed = place;
    this.#restless = true;
  }

  resize() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    this.dense = Math.min(window.devicePixelRatio || 1, DENSEST);
    Object.assign(this.canvas, { width: width * this.dense, height: height * this.dense });
    Object.assign(this.camera, { width, height });
    this.refit();
  }

  // True while it wants to be drawn again.
  paint(now, fresh, fully) {
    if (fresh) this.#take();
    if (fresh || fully || this.#restless) this.#restless = this.draw(now);
    return this.#restless;
  }

  #take() {
    const places = this.state.joints;
    if (!places) return;
    if (this.points.length !== places.length) {
      this.forget();
      this.points = new Float64Array(places.length);
    }
    const begins = this.state.begun !== this.#fitted.begun;
    if (begins) this.#rescale();
    const far = length(places);
    const same = Math.abs(far - this.#fitted.length) <= SAME * far;
    if (!same || (begins && !this.state.repeats)) this.#reach.forget();
    this.#reach.add(this.#joints, this.state.origin);
    if (!same || begins || this.#leaves) this.refit();
    else if (!this.settled) this.fit();
    Object.assign(this.#fitted, { begun: this.state.begun, length: far });
  }

  // Whether a part of the rod was outside of the picture that was drawn last. Under a pointer that
  // pulls it, the picture stays.
  get #leaves() {
    const { camera, points } = this;
    if (this.hand) return false;
    const outside = (at) =>
      !(points[at] >= 0 && points[at] <= camera.width) ||
      !(points[at + 1] >= 0 && points[at + 1] <= camera.height);
    for (let at = 0; at < points.length; at += 2) if (outside(at)) return true;
    return false;
  }

  // The joints as they are drawn, in metres from the origin of the state.
  get #joints() {
    const { times, support, clampAngle } = this.options;
    return enlarged(this.state.joints, times, support, clampAngle);
  }

  view(mode) {
    this.options.view = mode;
    if (this.state.joints) this.camera.change(mode, this.state.origin, this.state.point);
    else this.camera.mode = mode;
    this.refit();
  }

  // What is to be seen is other than before: it is fitted again, unless a part of it was chosen.
  refit() {
    if (!this.chosen) this.fit();
  }

  // The rod is drawn otherwise: where it has come before does not count.
  anew() {
    this.#reach.forget();
    this.refit();
  }

  // Shows the whole rod, with room to swing.
  fit() {
    const { state, camera } = this;
    const { support, show, loads, ties } = this.options;
    if (!state.joints || !(this.canvas.clientWidth > 0)) return;
    this.context.font = FONT; // a canvas that was resized has forgotten it
    const { arrow, names } = most(loads, state, show);
    const fixed = ties.map(({ x, y }) => [x - state.origin[0], y - state.origin[1]]);
    const parts = around(this.#joints, state.point, camera.mode, support, arrow, fixed);
    // A rod that is held comes back to where it has been.
    const been = support !== "none" && camera.mode === "fixed" && this.#reach.from(state.origin);
    if (been) parts.push({ box: been, room: arrow });
    const [left, top, , high] = frame(this.context, camera.width, show.moment, names);
    const all = this.#two ? twice(parts, this.#fitted.length) : parts;
    const view = fitted(all, [camera.width, camera.height], [left, top + high]);
    camera.fit(view, state.origin, state.point);
    this.settled = true;
    this.chosen = false;
  }

  // Another rod: what was fitted to the one before is let go. Its state may be there already, or
  // come next.
  forget() {
    this.#reach.forget();
    this.fit();
    this.settled = this.chosen = false;
    this.#rescale();
  }

  #rescale() {
    this.#moments.reset();
    this.#loads.reset();
  }

  // True while scales still move.
  draw(now) {
    const {
      context,
      camera,
      state,
      options: { show, loads },
    } = this;
    const colours = theme();
    if (!(camera.width > 1 && camera.height > 1)) return false;
    context.setTransform(this.dense, 0, 0, this.dense, 0, 0);
    context.font = FONT;
    camera.follow(state.origin, state.point);
    this.#pair();
    this.#ground(colours);
    if (!this.points.length) return false;
    const joints = this.#joints;
    camera.project(joints, this.points);
    const real = this.options.times === 1;
    if (show.trail && real) state.trail.draw(context, camera, state, colours);
    if (real) ghost(context, camera, state.ghost, colours, this.#two ? this.#fitted.length : 0);
    const limit = this.#rod(now, colours);
    if (real) this.#centre(colours);
    const rows = this.#loads.draw(context, camera, loads, state, this.points, show, now);
    const { mode } = this.options;
    const swings = swing(context, camera, joints, mode, this.#fitted.length, now, colours);
    if (this.kick) this.#aim(colours);
    pull(context, camera, state, this.points, this.hand, this.options.times, colours);
    this.#legend(limit, rows, colours);
    this.#time(colours);
    this.#hint(colours);
    return swings || this.#moments.moving || this.#loads.moving;
  }

  // The run that is kept comes to stand beside, or stands there no longer.
  #pair() {
    const { show, times } = this.options;
    const two = Boolean(show.beside && this.state.ghost?.length && times === 1);
    if (two === this.#two) return;
    this.#two = two;
    this.refit();
  }

  // The ends of the rod and their names.
  get #ends() {
    const at = (k) => [this.points.at(2 * k), this.points.at(2 * k + 1)];
    const first = this.options.support === "none" ? "nose" : "root";
    return [
      [at(0), at(1), first],
      [at(-1), at(-2), "tail"],
    ];
  }

  #ground(colours) {
    const { context, camera, state, options } = this;
    const paint = (on) => {
      on.fillStyle = colours.background;
      on.fillRect(0, 0, camera.width, camera.height);
      if (options.show.grid) grid(on, camera, state.origin, colours);
    };
    if (camera.place === null) {
      paint(context);
      return;
    }
    const key = [camera.place, options.show.grid, colours.background].join();
    this.#grid.put(context, this.dense, [0, 0, camera.width, camera.height], key, paint);
  }

  #legend(limit, rows, colours) {
    if (!limit && !rows.length) return;
    const names = rows.map(({ name }) => name);
    const box = frame(this.context, this.camera.width, limit, names);
    const key = JSON.stringify([limit, rows]) + colours.background;
    const paint = (on) => legend(on, box, limit, rows, colours);
    this.#key.put(this.context, this.dense, box, key, paint);
  }

  #rod(now, colours) {
    const { context, points, state, options } = this;
    const moments =
      options.show.moment && 2 * (state.moment?.length ?? 0) === points.length
        ? state.moment
        : null;
    let largest = 0;
    for (const moment of moments ?? []) largest = Math.max(largest, Math.abs(moment));
    const limit = moments ? this.#moments.follow(largest, now) : 0;
    const [c, s] = [Math.cos(options.clampAngle), Math.sin(options.clampAngle)];
    support(context, options.support, points[0], points[1], this.camera.direction(c, s), colours);
    const [x0, y0] = state.origin;
    const screen = (x, y) => this.camera.screen(x - x0, y - y0);
    anchors(context, points, options, screen, colours);
    if (options.show.joints)
      joints(context, points, this.#links.width(points), Boolean(moments), colours);
    this.#links.draw(context, points, moments, limit, colours);
    bodies(context, points, options.bodies, colours);
    if (options.show.ends) ends(context, this.#ends, colours);
    return limit;
  }

  #centre(colours) {
    const {
      context,
      camera,
      state: { point },
      options: { show },
    } = this;
    if (!Number.isFinite(point?.[0]) || !Number.isFinite(point?.[1])) return;
    const [x, y] = camera.screen(point[0], point[1]);
    if (show.axes && Number.isFinite(point[2])) {
      const first = camera.direction(Math.cos(point[2]), Math.sin(point[2]));
      axes(context, x, y, first, colours);
    }
    if (show.cg) centre(context, x, y, colours);
  }

  // The arrow begins at the link, wherever that has moved to; what is dragged so far beside its end.
  #aim(colours) {
    const { link, share, dx, dy } = this.kick;
    const [ax, ay, bx, by] = this.points.subarray(2 * link, 2 * link + 4);
    const [x, y] = [ax + share * (bx - ax), ay + share * (by - ay)];
    arrows(this.context, [[x, y, dx, dy]], colours.kick, 3);
    const impulse = Math.hypot(...this.camera.metres(dx, dy)) * this.options.perMetre;
    this.context.textAlign = dx < 0 ? "right" : "left";
    this.context.textBaseline = "middle";
    this.context.fillStyle = colours.ink;
    const beside = Math.sign(dx || 1) * 8;
    outlined(this.context, `${short(impulse, 3)} N s`, x + dx + beside, y + dy, colours);
  }

  #time(colours) {
    if (this.state.t === null) return;
    this.context.fillStyle = colours.ink;
    this.context.textAlign = "left";
    this.context.textBaseline = "top";
    outlined(this.context, `t = ${this.state.clock} s`, 8, 10, colours);
    const { times, mode } = this.options;
    const kept = over(this.state.kept, this.state.t);
    const notes = [mode?.text, times === 1 ? null : `displacements \u00d7 ${times}`, kept];
    this.context.fillStyle = colours.present;
    notes
      .filter((note) => note)
      .forEach((note, k) => outlined(this.context, note, 8, 28 + 18 * k, colours));
  }

  // Of the link that is pointed at.
  #hint(colours) {
    const { context, camera, state, points, options } = this;
    const pointed = this.#pointed;
    const hit = pointed && met(points, ...pointed);
    if (!hit) return;
    hint(context, camera, points, pointed, hit, said(state, options.loads, hit.link), colours);
  }
}
