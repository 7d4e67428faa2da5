// Loads as arrows to scale, each kind of them with its length in the legend.
//
// A load is {term, layer: what switches it, label, kind, colours: [on white, on black]}, as the page
// has it from the vocabulary of the server.

import { size } from "./camera.js";
import { arrows, atEnd, curved } from "./rod_marks.js";
import { Scale, short } from "./scales.js";
import { dark } from "./theme.js";

const APART = 7; // pixels from one arrow to the next
const each = ({ forces }, term) => forces[term];
const couple = (state, term) => state[`couple:${term}`]; // its point and its moment
const moment = (state, term) => couple(state, term)?.slice(2);
// By kind: pixels of the longest arrow at the end of its scale, width of a line, unit, the forces
// that are to scale, their arrows [x, y, dx, dy] in pixels, and what draws these.
const KINDS = {
  point: { longest: 64, width: 3, unit: "N", forces: whole, arrows: atPoint },
  mass: { longest: 64, width: 2.4, unit: "m/s\u00b2", forces: each, arrows: atCentre },
  joints: { longest: 50, width: 1.2, unit: "N", forces: each, arrows: atJoints },
  link: { longest: 90, width: 2.4, unit: "N m", forces: moment, arrows: about, draw: curved },
};

// Loads that are drawn of a state, whether they are zero by now or not.
const drawn = (loads, state, show) =>
  loads.filter(({ term, layer, kind }) => show[layer] && KINDS[kind].forces(state, term));

// What that takes: arrow, the longest at the rod in pixels; names, those that the legend may have.
export function most(loads, state, show) {
  const seen = drawn(loads, state, show);
  const points = seen.some(({ kind }) => kind === "point");
  return { arrow: points ? KINDS.point.longest + APART : 0, names: seen.map(({ label }) => label) };
}

export class Loads {
  #scales = Object.fromEntries(Object.keys(KINDS).map((kind) => [kind, new Scale()]));

  // Draws what `show` names and the state has; rows of the legend.
  draw(context, camera, loads, state, points, show, now) {
    const rows = [];
    const seen = drawn(loads, state, show);
    for (const [kind, of] of Object.entries(KINDS)) {
      const { longest, width, unit, forces, arrows: found, draw = arrows } = of;
      const those = seen.filter((load) => load.kind === kind);
      const sizes = those.map(({ term }) => largest(forces(state, term)));
      const limit = this.#scales[kind].follow(Math.max(0, ...sizes), now);
      those.forEach((load, k) => {
        if (!(sizes[k] > 0)) return;
        const arrow = (x, y) => camera.direction(x, y).map((d) => (d * longest) / limit);
        const colour = load.colours[Number(dark())];
        draw(context, found(state, points, arrow, load.term, camera), colour, width);
        // An arrow of half the scale, which is a round number.
        const text = `scale ${short(limit / 2, 3)} ${unit}`;
        rows.push({ name: load.label, colour, length: longest / 2, text });
      });
    }
    return rows;
  }
}

// The sum of those on the joints.
function whole({ forces }, term) {
  const sum = [0, 0];
  forces[term]?.forEach((force, k) => (sum[k % 2] += force));
  return forces[term] && sum;
}

// The size of the largest of some forces x0, y0, x1, ...
function largest(forces) {
  let size = 0;
  for (let at = 0; at < forces.length; at += 2)
    size = Math.max(size, Math.hypot(forces[at], forces[at + 1] ?? 0) || 0);
  return size;
}

// One at the joint upon which the force acts, or between two, ...
function atPoint(state, points, arrow, term) {
  const [forces, place] = [state.forces[term], [0, 0]];
  let [at, most, total] = [points.length - 2, 0, 0];
  for (let k = 0; k < forces.length; k += 2) {
    const size = Math.hypot(forces[k], forces[k + 1]);
    if (size > most) [at, most] = [k, size];
    total += size;
    place[0] += size * points[k];
    place[1] += size * points[k + 1];
  }
  const beside = at ? at - 2 : 2;
  const [x, y] = place.map((sum) => sum / total);
  return [atEnd([x, y], [points[beside], points[beside + 1]], arrow(...whole(state, term)))];
}

// ... one about the point of a couple, [x, y, length], ...
function about(state, points, arrow, term, camera) {
  const [x, y, size] = couple(state, term);
  return [[...camera.screen(x, y), Math.sign(size) * Math.hypot(...arrow(size, 0))]];
}

// ... one at the centre of gravity, ...
function atCentre(state, points, arrow, term, camera) {
  return [[...camera.screen(state.point[0], state.point[1]), ...arrow(...state.forces[term])]];
}

// ... or as many along the rod as can be told apart.
function atJoints(state, points, arrow, term) {
  const [forces, end] = [state.forces[term], points.length - 2];
  const [left, top, right, low] = size(points).box;
  const across = Math.max(right - left + low - top, 1); // about the length of the rod in pixels
  const every = 2 * Math.ceil((APART * end) / 2 / across);
  const list = [];
  for (let k = end; k >= 0; k -= every)
    list.push([points[k], points[k + 1], ...arrow(forces[k], forces[k + 1])]);
  return list;
}
