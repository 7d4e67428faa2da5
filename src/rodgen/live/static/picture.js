// The rod as it is now, drawn on a canvas.

import { around, Camera, fitted } from "./camera.js";
import { anchors, support } from "./rod_anchors.js";
import { grid } from "./rod_grid.js";
import { joints, Links } from "./rod_links.js";
import { Loads, most } from "./rod_loads.js";
import {
  arrows,
  axes,
  bodies,
  centre,
  frame,
  legend,
  outlined,
} from "./rod_marks.js";
import { Scale, short, Written } from "./scales.js";
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

export class Picture {
  camera = new Camera();
  points = new Float64Array(0); // joints in pixels
  kick = null; // {link, share, dx, dy}, in pixels, while it is drawn
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
  };
  #grid = new Layer();
  #key = new Layer();
  #links = new Links();
  #loads = new Loads();
  #moments = new Scale();
  #clock = new Written();
  settled = false; // what is shown was fitted to this rod, or chosen since
  chosen = false; // by who looks: another size of the picture leaves it alone
  #restless = false;

  constructor(canvas, state) {
    this.canvas = canvas;
    this.state = state;
    this.context = canvas.getContext("2d", { alpha: false });
  }

  resize() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    this.dense = Math.min(window.devicePixelRatio || 1, DENSEST);
    Object.assign(this.canvas, { width: width * this.dense, height: height * this.dense });
    Object.assign(this.camera, { width, height });
    if (!this.chosen) this.fit();
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
    if (!this.settled) this.fit();
  }

  view(mode) {
    this.options.view = mode;
    if (this.state.joints) this.camera.change(mode, this.state.origin, this.state.point);
    else this.camera.mode = mode;
  }

  // Shows the whole rod, with room to swing.
  fit() {
    const { state, camera } = this;
    const { support, show, loads, ties } = this.options;
    if (!state.joints || !(this.canvas.clientWidth > 0)) return;
    this.context.font = FONT; // a canvas that was resized has forgotten it
    const { arrow, names } = most(loads, state, show);
    const fixed = ties.map(({ x, y }) => [x - state.origin[0], y - state.origin[1]]);
    const parts = around(state.joints, state.point, camera.mode, support, arrow, fixed);
    const [left, top, , high] = frame(this.context, camera.width, show.moment, names);
    const view = fitted(parts, [camera.width, camera.height], [left, top + high]);
    camera.fit(view, state.origin, state.point);
    this.settled = true;
    this.chosen = false;
  }

  // Another rod: what was fitted to the one before is let go. Its state may be there already, or
  // come next.
  forget() {
    this.fit();
    this.settled = this.chosen = false;
    this.resetScale();
  }

  resetScale() {
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
    this.#ground(colours);
    if (!this.points.length) return false;
    camera.project(state.joints, this.points);
    if (show.trail) state.trail.draw(context, camera, state, colours);
    const limit = this.#rod(now, colours);
    this.#centre(colours);
    const rows = this.#loads.draw(context, camera, loads, state, this.points, show, now);
    if (this.kick) this.#aim(colours);
    this.#legend(limit, rows, colours);
    this.#time(colours);
    return this.#moments.moving || this.#loads.moving;
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
    this.#links.draw(context, points, moments, limit, colours);
    if (options.show.joints)
      joints(context, points, this.#links.width(points), Boolean(moments), colours);
    bodies(context, points, options.bodies, colours);
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
    this.context.fillText(`t = ${this.#clock.of(this.state.t)} s`, 8, 10);
  }
}
