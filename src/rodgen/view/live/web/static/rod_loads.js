// Forces and gravity as arrows to scale, each kind with its length in the legend.

import { Scale } from "./calm.js";
import { arrows, atEnd } from "./rod_marks.js";
import { short } from "./numbers.js";

const LONGEST = 64; // pixels of the longest arrow at the end of its scale
const APART = 7; // pixels from one of these to the next
const SPREAD = 50; // and of forces at all joints
const FORCES = [
  ["follower", "follower", "follower force"],
  ["tip", "tip_load", "tip load"],
];

// What is drawn of a state, whether it is zero by now or not: arrow, the longest at the tail in
// pixels; rows, how many the legend may have.
export function most(state, show) {
  const forces = FORCES.filter(([key, term]) => show[key] && state.forces[term]).length;
  const gravity = show.gravity && state.point?.[3];
  const damping = show.damping && state.forces.external_damping;
  const rows = forces + Boolean(gravity) + Boolean(damping);
  return { arrow: forces ? LONGEST + APART : 0, rows };
}

export class Loads {
  #ends = new Scale(); // of forces at the tail
  #damping = new Scale();
  #gravity = new Scale();

  get #scales() {
    return [this.#ends, this.#damping, this.#gravity];
  }

  get moving() {
    return this.#scales.some((scale) => scale.moving);
  }

  reset() {
    for (const scale of this.#scales) scale.reset();
  }

  // Draws what `show` names and the state has; rows of the legend.
  draw(context, camera, state, points, show, colours, now) {
    const rows = [];
    this.#tail(context, camera, state, points, show, colours, now, rows);
    if (show.gravity) this.#weight(context, camera, state, colours, now, rows);
    if (show.damping) this.#spread(context, camera, state, points, colours, now, rows);
    return rows;
  }

  #tail(context, camera, state, points, show, colours, now, rows) {
    const at = points.length - 2;
    const seen = FORCES.filter(
      ([key, term]) => show[key] && state.forces[term]?.length === points.length,
    );
    const forces = seen.map(([, term]) => state.forces[term].slice(at));
    const limit = this.#ends.follow(Math.max(0, ...forces.map((f) => Math.hypot(...f))), now);
    const [end, before] = [points.slice(at), points.slice(at - 2, at)];
    seen.forEach(([, term, name], k) => {
      const size = Math.hypot(...forces[k]);
      if (!(size > 0)) return;
      const arrow = camera.direction(...forces[k]).map((d) => (d * LONGEST) / limit);
      arrows(context, [atEnd(end, before, arrow)], colours[term], 3);
      rows.push(row(name, colours[term], this.#ends, LONGEST, "N"));
    });
  }

  #spread(context, camera, state, points, colours, now, rows) {
    const forces = state.forces.external_damping;
    if (forces?.length !== points.length) return;
    let largest = 0;
    for (let k = 0; k < forces.length; k += 2) {
      largest = Math.max(largest, Math.hypot(forces[k], forces[k + 1]));
    }
    const limit = this.#damping.follow(largest, now);
    if (!(limit > 0)) return;
    const list = [];
    const end = points.length - 2;
    const every = 2 * Math.ceil((APART * end) / 2 / Math.max(across(points), 1));
    for (let k = end; k >= 0; k -= every) {
      const arrow = camera.direction(forces[k], forces[k + 1]).map((d) => (d * SPREAD) / limit);
      list.push([points[k], points[k + 1], ...arrow]);
    }
    arrows(context, list, colours.external_damping, 1.2);
    rows.push(row("damping", colours.external_damping, this.#damping, SPREAD, "N"));
  }

  #weight(context, camera, state, colours, now, rows) {
    const [x, y, , size] = state.point ?? [];
    if (!size) return;
    const limit = this.#gravity.follow(Math.abs(size), now);
    const arrow = camera.direction(0, -size).map((d) => (d * LONGEST) / limit);
    arrows(context, [[...camera.screen(x, y), ...arrow]], colours.gravity, 2.4);
    rows.push(row("gravity", colours.gravity, this.#gravity, LONGEST, "m/s\u00b2"));
  }
}

// The sum of the sides of the box about the points: about the length of the rod in pixels.
function across(points) {
  const [xs, ys] = [0, 1].map((k) =>
    points.filter((_, at) => at % 2 === k && Number.isFinite(points[at])),
  );
  return Math.max(...xs) - Math.min(...xs) + Math.max(...ys) - Math.min(...ys);
}

// An arrow of a round size, as long as one of that size is drawn.
function row(name, colour, scale, longest, unit) {
  const value = scale.value / 2;
  const length = (value * longest) / scale.shown;
  return { name, colour, length, text: `${short(value, 3)} ${unit}` };
}
