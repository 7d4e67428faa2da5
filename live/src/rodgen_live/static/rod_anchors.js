// What holds the rod: the support of its start, springs to fixed points, a foundation.

const BED = 26; // pixels from the straight rod to the ground of a foundation
const MOST_SPRINGS = 24; // of a foundation
const APART = 18; // pixels between them at least
const [LEAST, COILS, HALF] = [16, 4, 4]; // of a spring: its shortest, coils, half their width [pixels]

// The support at (x, y): a wall that holds a clamped rod, a triangle under a pinned one;
// (dx, dy): the direction of the rod there, in pixels.
export function support(context, kind, x, y, [dx, dy], colours) {
  if (!kind || kind === "none") return;
  context.save();
  context.translate(x, y);
  if (kind === "wall") context.rotate(Math.atan2(dy, dx) + Math.PI / 2);
  Object.assign(context, { strokeStyle: colours.faint, fillStyle: colours.grid, lineWidth: 2 });
  if (kind === "pin") pin(context, 18);
  else hatch(context, -18, 18, 0);
  context.restore();
}

// A triangle on the ground, its upper corner at the origin.
function pin(context, high) {
  context.beginPath();
  context.moveTo(-0.6 * high, high);
  context.lineTo(0, 0);
  context.lineTo(0.6 * high, high);
  context.closePath();
  context.fill();
  context.stroke();
  hatch(context, -high, high, high);
}

// A line with hatching below it.
export function hatch(context, from, to, y) {
  context.beginPath();
  context.moveTo(from, y);
  context.lineTo(to, y);
  context.stroke();
  context.lineWidth = 1;
  context.beginPath();
  for (let x = from; x < to; x += 6) {
    context.moveTo(x, y + 7);
    context.lineTo(x + 6, y);
  }
  context.stroke();
}

// A coiled spring; a line where there is no room for coils.
export function spring(context, [x, y], [toX, toY]) {
  const [dx, dy] = [toX - x, toY - y];
  const length = Math.hypot(dx, dy);
  context.moveTo(x, y);
  if (length > LEAST) {
    const [nx, ny] = [(-HALF * dy) / length, (HALF * dx) / length];
    for (let k = 0; k <= 2 * COILS; k++) {
      const share = 0.2 + (0.6 * k) / (2 * COILS);
      const side = k % (2 * COILS) ? (k % 2 ? 1 : -1) : 0;
      context.lineTo(x + share * dx + side * nx, y + share * dy + side * ny);
    }
  }
  context.lineTo(toX, toY);
}

// The point of a link at a share of it, of joints x0, y0, x1, ... in pixels or in metres.
export function along(points, link, share) {
  const [ax, ay, bx, by] = points.subarray(2 * link, 2 * link + 4);
  return [ax + share * (bx - ax), ay + share * (by - ay)];
}

// The ground below the straight rod, from `bed` in pixels, with springs from it to the rod.
function foundation(context, points, [[x, y], [toX, toY]], colours) {
  const [dx, dy] = [toX - x, toY - y];
  const length = Math.hypot(dx, dy);
  // The side that is lower in the picture, whichever way the rod runs.
  const side = dx < 0 ? -BED : BED;
  const [downX, downY] = [(-side * dy) / length || 0, (side * dx) / length || 0];
  const links = points.length / 2 - 1;
  const count = Math.max(1, Math.min(MOST_SPRINGS, links, Math.floor(length / APART)));
  context.strokeStyle = colours.faint;
  context.lineWidth = 1;
  context.beginPath();
  for (let k = 0; k <= count; k++) {
    const at = (k / count) * links;
    const link = Math.min(Math.floor(at), links - 1);
    const share = k / count;
    const ground = [x + share * dx + downX, y + share * dy + downY];
    spring(context, along(points, link, at - link), ground);
  }
  context.stroke();
  context.save();
  context.translate(...(dx < 0 ? [toX, toY] : [x, y]));
  context.translate(downX, downY);
  context.rotate(dx < 0 ? Math.atan2(-dy, -dx) : Math.atan2(dy, dx));
  context.lineWidth = 2;
  hatch(context, 0, length, 0);
  context.restore();
}

// Supports {link, share, x, y} as springs from the rod to where they are fixed, and the foundation
// along `bed`, [[x, y], [x, y]]; screen: from metres to pixels.
export function anchors(context, points, { ties, bed }, screen, colours) {
  context.save();
  if (bed.length) foundation(context, points, bed.map((end) => screen(...end)), colours);
  for (const { link, share, x, y } of ties) {
    if (2 * link + 4 > points.length) continue; // the rod before
    const fixed = screen(x, y);
    Object.assign(context, { strokeStyle: colours.faint, fillStyle: colours.grid, lineWidth: 1.5 });
    context.beginPath();
    spring(context, along(points, link, share), fixed);
    context.stroke();
    context.save();
    context.translate(...fixed);
    pin(context, 11);
    context.restore();
  }
  context.restore();
}
