// A pull: the spring from a point of a link to where the pointer holds it, or to where that left it.

import { along, spring } from "./rod_anchors.js";
import { outlined } from "./rod_marks.js";
import { short } from "./scales.js";

const END = 5; // pixels, the radius of the far end
const EDGE = 10; // pixels of the picture, in which no force is written
const NEAR = 14; // pixels from it that still take hold of it

// Where the far end of the pull of a state is drawn, in pixels; displacements are drawn `times` as
// large.
function drawn(camera, state, points, times) {
  const [link, share, x, y] = state.pull;
  const [px, py] = along(points, link, share);
  const [fromX, fromY] = along(state.joints, link, share);
  const [dx, dy] = camera.direction(x - fromX, y - fromY);
  const scale = camera.scale * times;
  return [px + scale * dx, py + scale * dy];
}

// Whether a state has a pull on this rod.
const has = ({ pull, joints }) => pull?.length && 2 * pull[0] + 4 <= joints.length;

// The world's place of a far end that is held at (px, py), for a point of a link [m].
export function held({ link, share, x, y }, camera, state, points, times) {
  const [px, py] = along(points, link, share);
  const [dx, dy] = camera.metres(x - px, y - py);
  const [fromX, fromY] = along(state.joints, link, share);
  return [state.origin[0] + fromX + dx / times, state.origin[1] + fromY + dy / times];
}

// The point of the pull whose far end is at (px, py), or null.
export function caught(px, py, camera, state, points, times) {
  if (!has(state)) return null;
  const [x, y] = drawn(camera, state, points, times);
  const [link, share] = state.pull;
  return Math.hypot(x - px, y - py) <= NEAR ? { link, share } : null;
}

// Draws a pull: `hand` is what the pointer holds, {link, share, x, y}; else it is that of the state.
export function pull(context, camera, state, points, hand, times, colours) {
  if (!hand && !has(state)) return;
  const [link, share] = hand ? [hand.link, hand.share] : state.pull;
  if (2 * link + 4 > points.length) return;
  const from = along(points, link, share);
  const to = hand ? [hand.x, hand.y] : drawn(camera, state, points, times);
  context.strokeStyle = context.fillStyle = colours.centre;
  context.lineWidth = 2;
  context.beginPath();
  spring(context, from, to);
  context.stroke();
  context.beginPath();
  context.arc(...to, END, 0, 2 * Math.PI);
  if (hand) context.stroke();
  else context.fill();
  if (!has(state)) return;
  const textAlign = to[0] < from[0] ? "right" : "left";
  Object.assign(context, { textAlign, textBaseline: "middle", fillStyle: colours.ink });
  const force = Math.hypot(state.pull[4], state.pull[5]);
  const beside = to[0] < from[0] ? -2 * END : 2 * END;
  const [x, y] = [camera.width, camera.height].map((size, k) =>
    Math.min(Math.max(to[k], EDGE), size - EDGE),
  );
  outlined(context, `${short(force, 3)} N`, x + beside, y, colours);
}
