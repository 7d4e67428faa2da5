// The rod as it is now, drawn on a canvas.

import { about, around, Camera, fitted, size } from "./camera.js";
import { tell } from "./dom.js";
import { along, anchors, support } from "./rod_anchors.js";
import { enlarged } from "./rod_enlarged.js";
import { ASIDE, ghost, over } from "./rod_ghost.js";
import { grid } from "./rod_grid.js";
import { met, said } from "./rod_hint.js";
import { joints, length, line, links } from "./rod_links.js";
import { Loads, most } from "./rod_loads.js";
import { arrows, axes, bodies, centre, ends, frame, legend, outlined } from "./rod_marks.js";
import { swing } from "./rod_modes.js";
import { obstacles } from "./rod_obstacles.js";
import { pull } from "./rod_pull.js";
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
    const [wide, high] = [Math.ceil(width * dense), Math.ceil(height * dense)];
    if (this.#key !== full) {
      this.#key = full;
      Object.assign(this.#canvas, { width: wide, height: high });
      const own = this.#canvas.getContext("2d");
      own.scale(dense, dense);
      own.font = context.font;
      paint(own);
    }
    context.drawImage(this.#canvas, x, y, wide / dense, high / dense);
  }
}

const FONT = "12px Roboto, system-ui, sans-serif";
const DENSEST = 2; // device pixels per pixel that are drawn at most
const SAME = 1e-3; // of its length, by which a rod may differ that is fitted
const ROOM = 35; // pixels left free about what is fitted, at least
const NOWHERE = [Infinity, Infinity, -Infinity, -Infinity]; // an empty box

export class Picture {
  camera = new Camera();
  points = new Float64Array(0); // joints in pixels
  kick = null; // {link, share, dx, dy}, in pixels, while it is drawn
  hand = null; // {link, share, x, y}, in pixels, while the pointer pulls
  pointed = null; // [x, y] of a pointer that rests, in pixels
  chosen = false; // by who looks: another size of the picture leaves it alone
  #grid = new Layer();
  #key = new Layer();
  #loads = new Loads();
  #moments = new Scale();
  #been = NOWHERE; // where the rod has come, as it was drawn: a box, absolute [m]
  #swings = false;
  #another = true; // a rod that was not fitted yet
  #begun = null; // the run that was fitted last, and the length of its rod
  #length = 0;
  #two = false; // whether the run that is kept stands beside

  // options: the props of rod.js; hint: an element for what is said of a link.
  constructor(canvas, hint, state, options) {
    Object.assign(this, { canvas, hint, state, options });
    this.context = canvas.getContext("2d", { alpha: false });
    this.camera.mode = options.view;
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
    if (fresh || fully || this.#swings) this.#swings = this.draw(now);
    return this.#swings;
  }

  #take() {
    const { joints: places, begun, repeats, origin } = this.state;
    if (!places) return;
    if (this.points.length !== places.length) {
      this.forget();
      this.points = new Float64Array(places.length);
    }
    const begins = begun !== this.#begun;
    if (begins) this.#rescale();
    const far = length(places);
    const other = this.#another || !(Math.abs(far - this.#length) <= SAME * far);
    [this.#begun, this.#length, this.#another] = [begun, far, false];
    if (other || (begins && !repeats)) this.#been = NOWHERE;
    const { box } = size(this.#joints);
    this.#been = about(this.#been, box.map((end, k) => end + origin[k % 2]));
    if (other || begins || this.#leaves) this.refit();
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
    return enlarged(this.state, this.options);
  }

  // What is to be seen is other than before: it is fitted again, unless a part of it was chosen.
  refit() {
    if (!this.chosen) this.fit();
  }

  // The rod is drawn otherwise: where it has come before does not count.
  anew() {
    this.#been = NOWHERE;
    this.refit();
  }

  // Shows the whole rod, with room to swing.
  fit() {
    const { state, camera, options } = this;
    const { support, show, loads, ties } = options;
    camera.mode = options.view;
    this.chosen = false;
    if (!state.joints || !(this.canvas.clientWidth > 0)) return;
    this.context.font = FONT; // a canvas that was resized has forgotten it
    const { arrow, names } = most(loads, state, show);
    const relative = (absolute) => absolute.map((part, k) => part - state.origin[k % 2]);
    const fixed = ties.map(({ x, y }) => relative([x, y]));
    let box = around(this.#joints, state.point, camera.mode, support, fixed);
    // A rod that is held comes back to where it has been.
    if (support !== "none" && camera.mode === "fixed") box = about(box, relative(this.#been));
    if (this.#two) box[2] += ASIDE * this.#length;
    const [left, top, , high] = frame(this.context, camera.width, show.bending, names);
    const room = Math.max(ROOM, arrow);
    const view = fitted(box, room, [camera.width, camera.height], [left, top + high]);
    camera.fit(view, state.origin, state.point);
  }

  // Another rod: what was fitted to the one before is let go. Its state may be there already, or
  // come next.
  forget() {
    this.#been = NOWHERE;
    this.fit();
    this.#another = true;
    this.#rescale();
  }

  #rescale() {
    this.#moments = new Scale();
    this.#loads = new Loads();
  }

  // True while something swings.
  draw(now) {
    const { context, camera, state, points, options } = this;
    const { show, loads, mode, times } = options;
    const colours = theme();
    if (!(camera.width > 1 && camera.height > 1)) return false;
    context.setTransform(this.dense, 0, 0, this.dense, 0, 0);
    context.font = FONT;
    camera.follow(state.origin, state.point);
    this.#pair();
    this.#ground(colours);
    if (!points.length) return false;
    const joints = this.#joints;
    camera.project(joints, points);
    const real = times === 1;
    if (show.trail && real) state.trail.draw(context, camera, state, colours);
    if (real) ghost(context, camera, state.ghost, colours, this.#two ? this.#length : 0);
    const limit = this.#rod(now, colours);
    if (real) this.#centre(colours);
    const rows = this.#loads.draw(context, camera, loads, state, points, show, now);
    const swings = swing(context, camera, joints, mode, this.#length, now, colours);
    if (this.kick) this.#aim(colours);
    pull(context, camera, state, points, this.hand, times, colours);
    this.#legend(limit, rows, colours);
    this.#time(colours);
    this.#hint(colours);
    return swings;
  }

  // The run that is kept comes to stand beside, or stands there no longer.
  #pair() {
    const { show, times } = this.options;
    const two = Boolean(show.beside && this.state.ghost?.length && times === 1);
    if (two === this.#two) return;
    this.#two = two;
    this.refit();
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
    const { context, points, state, camera, options } = this;
    const { show } = options;
    const told = show.bending && 2 * (state.moment?.length ?? 0) === points.length;
    const moments = told ? state.moment : null;
    const largest = (moments ?? []).reduce((most, one) => Math.max(most, Math.abs(one)), 0);
    const limit = moments ? this.#moments.follow(largest, now) : 0;
    const clamp = state.point?.[3] ?? 0;
    const straight = camera.direction(Math.cos(clamp), Math.sin(clamp));
    support(context, options.support, points[0], points[1], straight, colours);
    const [x0, y0] = state.origin;
    const screen = (x, y) => camera.screen(x - x0, y - y0);
    anchors(context, points, options, screen, colours);
    obstacles(context, options.obstacles ?? [], screen, camera, colours);
    if (show.joints) joints(context, points, colours);
    links(context, points, moments, limit, colours);
    bodies(context, points, options.bodies, colours);
    if (show.ends) ends(context, points, options.support === "none" ? "nose" : "root", colours);
    return limit;
  }

  #centre(colours) {
    const { context, camera, state, options } = this;
    const [gx, gy, angle] = state.point ?? [];
    if (!Number.isFinite(gx) || !Number.isFinite(gy)) return;
    const [x, y] = camera.screen(gx, gy);
    if (options.show.axes && Number.isFinite(angle)) {
      axes(context, x, y, camera.direction(Math.cos(angle), Math.sin(angle)), colours);
    }
    if (options.show.cg) centre(context, x, y, colours);
  }

  // The arrow begins at the link, wherever that has moved to; what is dragged so far beside its end.
  #aim(colours) {
    const { link, share, dx, dy } = this.kick;
    const [x, y] = along(this.points, link, share);
    arrows(this.context, [[x, y, dx, dy]], colours.kick, 3);
    const impulse = Math.hypot(...this.camera.metres(dx, dy)) * this.options.perMetre;
    const textAlign = dx < 0 ? "right" : "left";
    Object.assign(this.context, { textAlign, textBaseline: "middle", fillStyle: colours.ink });
    const beside = Math.sign(dx || 1) * 8;
    outlined(this.context, `${short(impulse, 3)} N s`, x + dx + beside, y + dy, colours);
  }

  #time(colours) {
    const { context, state } = this;
    if (state.t === null) return;
    Object.assign(context, { textAlign: "left", textBaseline: "top", fillStyle: colours.ink });
    outlined(context, `t = ${state.clock} s`, 8, 10, colours);
    const { times, mode } = this.options;
    const enlarged = times === 1 ? null : `displacements \u00d7 ${times}`;
    const notes = [mode?.text, enlarged, over(state.kept, state.t)].filter((note) => note);
    context.fillStyle = colours.present;
    notes.forEach((note, k) => outlined(context, note, 8, 28 + 18 * k, colours));
  }

  // Of the link that is pointed at.
  #hint(colours) {
    const { context, state, points, pointed } = this;
    const hit = pointed && met(points, ...pointed);
    tell(this.hint, hit ? said(state, this.options.loads, hit.link) : [], pointed);
    if (hit) line(context, points.subarray(2 * hit.link, 2 * hit.link + 4), colours.present, 2);
  }
}
