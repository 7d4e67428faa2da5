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

// A line through x0, y0, x1, ... in pixels.
export function line(context, points, colour, width) {
  Object.assign(context, { strokeStyle: colour, lineWidth: width });
  context.lineCap = context.lineJoin = "round";
  context.beginPath();
  for (let at = 0; at < points.length; at += 2) context.lineTo(points[at], points[at + 1]);
  context.stroke();
}

const widthOf = (points) => Math.min(Math.max(length(points) / 70, 3), 9) || 3;

// points: x0, y0, x1, ... in pixels; moments: one a joint, or null.
export function links(context, points, moments, limit, colours) {
  const width = widthOf(points);
  context.globalAlpha = 0.5;
  line(context, points, colours.edge, width + 2);
  context.globalAlpha = 1;
  if (!moments || !(limit > 0)) {
    line(context, points, colours.link, width);
    return;
  }
  const sorted = Array.from({ length: CLASSES }, () => []); // one stroke for all of a colour
  for (let i = 0; i + 1 < moments.length; i++) {
    sorted[classed((moments[i] + moments[i + 1]) / 2, limit)].push(i);
  }
  context.lineWidth = width;
  classes(colours.moments, CLASSES).forEach((colour, k) => {
    if (sorted[k].length) some(context, points, sorted[k], colour);
  });
}

// Of the links, those of these numbers, which ascend.
function some(context, points, numbers, colour) {
  context.strokeStyle = colour;
  context.beginPath();
  let end = -1;
  for (const i of numbers) {
    const at = 2 * i;
    if (end !== i) context.moveTo(points[at], points[at + 1]);
    context.lineTo(points[at + 2], points[at + 3]);
    end = i + 1;
  }
  context.stroke();
}

// Discs at the joints, for the links to be drawn over, unless they would touch.
export function joints(context, points, colours) {
  const count = points.length / 2;
  const radius = widthOf(points) / 2 + BESIDE;
  if (!(length(points) / (count - 1) > 2 * radius + 1)) return;
  context.fillStyle = colours.joint;
  context.beginPath();
  for (let i = 0; i < count; i += 1) {
    const [x, y] = [points[2 * i], points[2 * i + 1]];
    context.moveTo(x + radius, y);
    context.arc(x, y, radius, 0, 2 * Math.PI);
  }
  context.fill();
}

// Where the tail and the centre of gravity have been, and when: the last places, in absolute
// coordinates.
export class Trail {
  #places = []; // [tail x, y, centre of gravity x, y, time], from first to last

  // Rows of a message, these numbers one after the other; `anew`: instead of those that are there;
  // `length` of the rod.
  add(rows, anew, length) {
    if (anew) this.#places = [];
    for (let at = 0; at < rows.length; at += WIDTH) {
      const [place, last] = [rows.slice(at, at + WIDTH), this.#places.at(-1)];
      const near = (k) => Math.abs(place[k] - last[k]) < CLOSE * length;
      if (!last || ![0, 1, 2, 3].every(near)) this.#places.push(place);
    }
    if (this.#places.length > 2 * MOST) this.#places.splice(0, this.#places.length - MOST);
  }

  // Up to the places of `state`, at its time t [s].
  draw(context, camera, { origin, joints, point, t }, colours) {
    // Times have come in single precision.
    const end = this.#places.findLastIndex((place) => place[WHEN] <= Math.fround(t)) + 1;
    const places = this.#places.slice(Math.max(0, end - MOST), end);
    if (!places.length) return;
    context.lineWidth = 1.2;
    context.lineJoin = "bevel";
    for (const [column, colour, [x, y]] of [
      [2, colours.centre, point ?? [NaN, NaN]],
      [0, colours.tail, joints.slice(-2)],
    ]) {
      context.strokeStyle = colour;
      const share = (places.length - 1) / PIECES;
      for (let piece = 0; piece < PIECES; piece++) {
        context.globalAlpha = 0.15 + (0.6 * (piece + 1)) / PIECES;
        context.beginPath();
        const part = places.slice(Math.floor(piece * share), Math.floor((piece + 1) * share) + 1);
        this.#piece(context, camera, origin, part, column);
        if (piece === PIECES - 1) context.lineTo(...camera.screen(x, y));
        context.stroke();
      }
    }
    context.globalAlpha = 1;
  }

  // Places that lie closer are passed over, but for the first and the last.
  #piece(context, camera, origin, places, column) {
    let [px, py] = [Infinity, Infinity];
    places.forEach((place, k) => {
      const [x, y] = camera.screen(place[column] - origin[0], place[column + 1] - origin[1]);
      const close = Math.abs(x - px) + Math.abs(y - py) < NEAR;
      if (close && k + 1 < places.length) return;
      context.lineTo(x, y);
      [px, py] = [x, y];
    });
  }
}
