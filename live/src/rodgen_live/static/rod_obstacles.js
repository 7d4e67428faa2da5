// Stops and walls: lines with hatching to the right of them.

import { hatch } from "./rod_anchors.js";

const BESIDE = 20; // pixels around the picture within which hatching is drawn

// The part of the way from a to b in pixels that is in a picture so wide and high, by Liang and
// Barsky; null where none is.
export function clipped([ax, ay], [bx, by], width, height) {
  const [dx, dy] = [bx - ax, by - ay];
  let [from, to] = [0, 1];
  const sides = [
    [-dx, ax + BESIDE],
    [dx, width + BESIDE - ax],
    [-dy, ay + BESIDE],
    [dy, height + BESIDE - ay],
  ];
  for (const [towards, left] of sides) {
    if (towards === 0 && left < 0) return null;
    if (towards < 0) from = Math.max(from, left / towards);
    if (towards > 0) to = Math.min(to, left / towards);
  }
  if (!(from < to)) return null;
  return [from, to].map((share) => [ax + share * dx, ay + share * dy]);
}

// Lines [[x, y], ...] in metres; screen: from metres to pixels.
export function obstacles(context, lines, screen, { width, height }, colours) {
  for (const line of lines) {
    const ends = line.map((end) => screen(...end));
    for (let k = 1; k < ends.length; k++) {
      const seen = clipped(ends[k - 1], ends[k], width, height);
      if (!seen) continue;
      const [[x, y], [toX, toY]] = seen;
      context.save();
      Object.assign(context, { strokeStyle: colours.faint, lineWidth: 2 });
      context.translate(x, y);
      context.rotate(Math.atan2(toY - y, toX - x));
      hatch(context, 0, Math.hypot(toX - x, toY - y), 0);
      context.restore();
    }
  }
}
