// How curves are drawn where uPlot's own line, which goes from left to right, does not do.

import { uPlot } from "./uplot.js";

const APART = 0.5; // pixels within which a point is not drawn beside the one before

// Calls draw(x, y, at) with the pixels of every point that has some.
function each(u, k, draw) {
  uPlot.orient(u, k, (_, xs, ys, across, up, toX, toY, left, top, wide, high) => {
    for (let at = 0; at < xs.length; at++) {
      const [x, y] = [toX(xs[at], across, wide, left), toY(ys[at], up, high, top)];
      draw(x, y, at);
    }
  });
}

// A curve in the order of its points; interrupted where one is not finite, and where x or y jumps by
// a period (0: it has none) on the way from one end of it to the other.
export const trace = (across, up) => (u, k) => {
  const stroke = new Path2D();
  const [xs, ys] = u.data[k];
  const leaps = (values, at, period) => period && Math.abs(values[at] - values[at - 1]) > period / 2;
  let [px, py] = [NaN, NaN];
  each(u, k, (x, y, at) => {
    const leapt = at && (leaps(xs, at, across) || leaps(ys, at, up));
    if (!leapt && Math.abs(x - px) < APART && Math.abs(y - py) < APART) return;
    if (leapt || Number.isNaN(px + py)) stroke.moveTo(x, y);
    else stroke.lineTo(x, y);
    [px, py] = [x, y];
  });
  return { stroke, fill: null, clip: null, band: null, gaps: null, flags: 0 };
};

export const straight = uPlot.paths.linear();

// Points `size` pixels of the screen across; hollow: as circles.
export const dots = (size, hollow = false) => (u, k) => {
  const path = new Path2D();
  each(u, k, (x, y) => {
    path.moveTo(x + size / 2, y);
    path.arc(x, y, size / 2, 0, 2 * Math.PI);
  });
  const [stroke, fill] = hollow ? [path, null] : [null, path];
  return { stroke, fill, clip: null, band: null, gaps: null, flags: 0 };
};
