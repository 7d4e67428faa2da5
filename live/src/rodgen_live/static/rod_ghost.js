// The rod of the run that is kept to compare with: pale, behind the rod itself, or beside it.

import { line } from "./rod_links.js";
import { outlined } from "./rod_marks.js";
import { short } from "./scales.js";

const WIDE = 4; // pixels
const PALE = 0.35;
export const ASIDE = 1.2; // lengths of the rod, from one to the other
const NAME = 18; // pixels from its first joint to its name

// What is said of the run that is kept where the rod is drawn at a time that it has not; `span`: of
// that run [s], null: no run is kept.
export const over = (span, t) => {
  if (!span || (span[0] <= t && t <= span[1])) return null;
  const [words, at] = t > span[1] ? ["has ended", span[1]] : ["begins", span[0]];
  return `the run that is kept ${words} at ${short(at, 4)} s`;
};

// `joints` in metres from the origin of the state: x0, y0, ...; none where it is not there now.
// `length`: of the rod that it stands beside [m]; 0: behind.
export function ghost(context, camera, joints, colours, length) {
  if (!joints?.length) return;
  context.save();
  context.translate(ASIDE * length * camera.scale, 0);
  if (length) {
    const [x, y] = camera.screen(joints[0], joints[1]);
    const { faint: fillStyle } = colours;
    Object.assign(context, { fillStyle, textAlign: "center", textBaseline: "top" });
    outlined(context, "run that is kept", x, y + NAME, colours);
  }
  context.globalAlpha = length ? 1 : PALE;
  const points = new Float64Array(joints.length);
  camera.project(joints, points);
  line(context, points, length ? colours.link : colours.ink, WIDE);
  context.restore();
}
