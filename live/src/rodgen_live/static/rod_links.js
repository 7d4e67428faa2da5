// Links and joints of a rod, coloured by the bending moment, and the trail of its tail and its centre of
// gravity.

import { classes } from "./theme.js";

const CLASSES = 64; // of colours
const MOST = 6000; // places of a trail
const [WIDTH, WHEN] = [5, 4]; // numbers of a place; which of them is its time
const PIECES = 4; // of a trail, one fainter than the next
const NEAR = 3; // pixels between the places that are drawn
const BESIDE = 2.2; // pixels that a joint stands out beside its links
const CLOSE = 1e-3; // of the rod's length: a place nearer to the last one is not kept

// 0 to CLASSES - 1 of a moment, by its root, on a scale that ends at `limit`: a moment of a hundredth
// of that is still seen beside it.
function classed(moment, limit) {
  const share = 0.5 + 0.5 * Math.sign(moment) * Math.sqrt(Math.abs(moment) / limit);
  return Math.min(Math.max(Math.floor(share * CLASSES), 0), CLASSES - 1);
}

// Of the line through x0, y0, x1, ...
export function length(points) {
  let sum = 0;
  for (let at = 2; at < points.length; at += 2) {
    sum += Math.hypot(points[at] - points[at - 2], points[at + 1] - points[at - 1]);
  }
  return sum;
}

export class Links {
  #heads = new Int32Array(CLASSES);
  #next = new Int32Array(0);

  // points: x0, y0, x1, ... in pixels; moment: one a joint, or null.
  draw(context, points, moment, limit, colours) {
    const links = points.length / 2 - 1;
    const width = this.width(points);
    context.lineCap = context.lineJoin = "round";
    this.#outline(context, points, width, colours);
    context.lineWidth = width;
    if (!moment || !(limit > 0)) {
      stroke(context, colours.link, () => path(context, points));
      return;
    }
    this.#sort(links, moment, limit);
    const table = classes(colours.moments, CLASSES);
    for (let k = 0; k < CLASSES; k++) {
      if (this.#heads[k] >= 0) stroke(context, table[k], () => this.#class(context, points, k));
    }
  }

  width(points) {
    return Math.min(Math.max(length(points) / 70, 3), 9) || 3;
  }

  #outline(context, points, width, colours) {
    context.lineWidth = width + 2;
    context.globalAlpha = 0.5;
    stroke(context, colours.edge, () => path(context, points));
    context.globalAlpha = 1;
  }

  // Links by colour, as lists through #next: one stroke for all of a colour.
  #sort(links, moment, limit) {
    if (this.#next.length !== links) this.#next = new Int32Array(links);
    this.#heads.fill(-1);
    for (let i = links - 1; i >= 0; i--) {
      const mean = (moment[i] + moment[i + 1]) / 2;
      const k = classed(mean, limit);
      this.#next[i] = this.#heads[k];
      this.#heads[k] = i;
    }
  }

  #class(context, points, k) {
    let end = -1;
    for (let i = this.#heads[k]; i >= 0; i = this.#next[i]) {
      const at = 2 * i;
      if (end !== i) context.moveTo(points[at], points[at + 1]);
      context.lineTo(points[at + 2], points[at + 3]);
      end = i + 1;
    }
  }
}

function stroke(context, colour, trace) {
  context.strokeStyle = colour;
  context.beginPath();
  trace();
  context.stroke();
}

function path(context, points) {
  context.moveTo(points[0], points[1]);
  for (let at = 2; at < points.length; at += 2) context.lineTo(points[at], points[at + 1]);
}

// Discs at the joints, for the links to be drawn over, unless they would touch; rotary springs where
// there is room.
export function joints(context, points, width, springs, colours) {
  const count = points.length / 2;
  const link = length(points) / (count - 1);
  const radius = width / 2 + BESIDE;
  if (!(link > 2 * radius + 1)) return;
  if (springs && link > 34) spirals(context, points, Math.min(link / 4, 14), colours);
  context.fillStyle = colours.joint;
  context.beginPath();
  for (let i = 0; i < count; i += 1) {
    const [x, y] = [points[2 * i], points[2 * i + 1]];
    context.moveTo(x + radius, y);
    context.arc(x, y, radius, 0, 2 * Math.PI);
  }
  context.fill();
}

// The usual sign of a rotary spring, about every inner joint.
function spirals(context, points, radius, colours) {
  context.strokeStyle = colours.faint;
  context.lineWidth = 1.2;
  context.beginPath();
  for (let at = 2; at < points.length - 2; at += 2) {
    const begin =
      Math.atan2(points[at + 1] - points[at - 1], points[at] - points[at - 2]) + Math.PI;
    for (let k = 0; k <= 40; k++) {
      const angle = begin + (k / 40) * 4 * Math.PI;
      const r = radius * (1 - (0.6 * k) / 40);
      const [x, y] = [points[at] + r * Math.cos(angle), points[at + 1] + r * Math.sin(angle)];
      if (k) context.lineTo(x, y);
      else context.moveTo(x, y);
    }
  }
  context.stroke();
}

// Where the tail and the centre of gravity have been, and when: the last places, in absolute
// coordinates.
export class Trail {
  #places = new Float64Array(WIDTH * MOST);
  #count = 0;

  // Rows of a message, tail x, y, centre of gravity x, y, and the time; `anew`: instead of those
  // that are there; `length` of the rod.
  add(rows, anew, length) {
    if (anew) this.#count = 0;
    for (let at = 0; at < rows.length; at += WIDTH) this.#keep(rows, at, CLOSE * length);
  }

  #keep(rows, at, close) {
    const last = WIDTH * ((this.#count - 1) % MOST);
    const moved = (k) => Math.abs(rows[at + k] - this.#places[last + k]);
    if (this.#count && Math.max(moved(0), moved(1), moved(2), moved(3)) < close) return;
    const next = WIDTH * (this.#count++ % MOST);
    for (let k = 0; k < WIDTH; k++) this.#places[next + k] = rows[at + k];
  }

  // The number of the first place after a time, from a place on.
  #after(t, first) {
    let [low, high] = [first, this.#count];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.#places[WIDTH * (middle % MOST) + WHEN] > t) high = middle;
      else low = middle + 1;
    }
    return low;
  }

  // Up to the places of `state`, at its time t [s].
  draw(context, camera, { origin, joints, point, t }, colours) {
    const first = Math.max(0, this.#count - MOST);
    const count = this.#after(Math.fround(t), first); // times have come in single precision
    if (count === first) return;
    context.lineWidth = 1.2;
    context.lineJoin = "bevel";
    const span = (count - 1 - first) / PIECES;
    for (const [column, colour, end] of [
      [2, colours.centre, point ?? [NaN, NaN]],
      [0, colours.tail, joints.slice(-2)],
    ]) {
      context.strokeStyle = colour;
      for (let piece = 0; piece < PIECES; piece++) {
        context.globalAlpha = 0.15 + (0.6 * (piece + 1)) / PIECES;
        context.beginPath();
        const ends = [piece, piece + 1].map((k) => first + Math.floor(k * span));
        this.#piece(context, camera, origin, column, ...ends);
        if (piece === PIECES - 1) context.lineTo(...camera.screen(end[0], end[1]));
        context.stroke();
      }
    }
    context.globalAlpha = 1;
  }

  // Places that lie closer are passed over.
  #piece(context, camera, origin, column, from, to) {
    let [px, py] = [Infinity, Infinity];
    for (let k = from; k <= to; k++) {
      const at = WIDTH * (k % MOST) + column;
      const [x, y] = camera.screen(this.#places[at] - origin[0], this.#places[at + 1] - origin[1]);
      if (k !== from && k !== to && Math.abs(x - px) + Math.abs(y - py) < NEAR) continue;
      if (k === from) context.moveTo(x, y);
      else context.lineTo(x, y);
      [px, py] = [x, y];
    }
  }
}
