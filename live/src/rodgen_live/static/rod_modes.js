// A mode of the rod over its picture, swinging about the joints as they are.

import { line } from "./rod_links.js";

const SHARE = 0.1; // of the length: the largest displacement
const BEAT = 1.4; // seconds of a period, whatever the frequency
const still = matchMedia("(prefers-reduced-motion: reduce)");

// The joints at a phase of the mode {re, im}, displaced from x0, y0, x1, ...
function displaced(joints, { re, im }, size, phase) {
  const [c, s] = [size * Math.cos(phase), size * Math.sin(phase)];
  return joints.map((x, at) => x + c * re[at] - s * im[at]);
}

// Draws a mode, and its other end faintly. True while it moves.
export function swing(context, camera, joints, mode, far, now, colours) {
  if (mode?.re.length !== joints.length) return false; // none, or that of the rod before
  const phase = still.matches ? 0 : (2 * Math.PI * now) / (1000 * BEAT);
  const points = new Float64Array(joints.length);
  for (const [turn, width, alpha] of [
    [Math.PI, 2, 0.35],
    [0, 3, 0.9],
  ]) {
    camera.project(displaced(joints, mode, SHARE * far, phase + turn), points);
    context.globalAlpha = alpha;
    line(context, points, colours.centre, width);
  }
  context.globalAlpha = 1;
  return !still.matches;
}
