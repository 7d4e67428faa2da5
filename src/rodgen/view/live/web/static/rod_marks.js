// What stands by the rod: support, centre of gravity, principal axes, arrows.

const TURN = 2 * Math.PI;

// The quartered circle.
export function centre(context, x, y, colours) {
  const radius = 8;
  context.fillStyle = colours.background;
  disc(context, x, y, radius);
  context.fill();
  context.fillStyle = colours.centre;
  for (const begin of [0, Math.PI]) {
    context.beginPath();
    context.moveTo(x, y);
    context.arc(x, y, radius, begin, begin + TURN / 4);
    context.fill();
  }
  context.strokeStyle = colours.centre;
  context.lineWidth = 1.5;
  disc(context, x, y, radius);
  context.stroke();
}

function disc(context, x, y, radius) {
  context.beginPath();
  context.arc(x, y, radius, 0, TURN);
}

// Both principal axes through (x, y); (dx, dy) is the direction of the first, in pixels.
export function axes(context, x, y, [dx, dy], colours) {
  const size = Math.hypot(dx, dy) || 1;
  const [c, s] = [dx / size, dy / size];
  context.strokeStyle = context.fillStyle = colours.principal;
  context.lineWidth = 1.2;
  context.setLineDash([10, 3, 2, 3]);
  context.beginPath();
  for (const [ex, ey, reach] of [
    [c, s, 90],
    [s, -c, 60],
  ]) {
    context.moveTo(x - ex * reach, y - ey * reach);
    context.lineTo(x + ex * reach, y + ey * reach);
  }
  context.stroke();
  context.setLineDash([]);
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText("1", x + c * 100, y + s * 100);
  context.fillText("2", x + s * 70, y - c * 70);
}

// Arrows [x, y, dx, dy] in pixels, from (x, y); those of a kind in one stroke and one fill.
export function arrows(context, list, colour, width = 2) {
  const head = 2 + 2.6 * width;
  context.strokeStyle = context.fillStyle = colour;
  context.lineWidth = width;
  context.lineCap = "butt";
  const seen = list.filter(([, , dx, dy]) => Math.hypot(dx, dy) > 1.5);
  context.beginPath();
  for (const [x, y, dx, dy] of seen) {
    const share = Math.max(1 - (0.8 * head) / Math.hypot(dx, dy), 0);
    context.moveTo(x, y);
    context.lineTo(x + dx * share, y + dy * share);
  }
  context.stroke();
  context.beginPath();
  for (const [x, y, dx, dy] of seen) {
    const size = Math.hypot(dx, dy);
    const long = Math.min(head, size);
    const [ux, uy] = [(dx / size) * long, (dy / size) * long];
    context.moveTo(x + dx, y + dy);
    context.lineTo(x + dx - ux - 0.4 * uy, y + dy - uy + 0.4 * ux);
    context.lineTo(x + dx - ux + 0.4 * uy, y + dy - uy - 0.4 * ux);
  }
  context.fill();
}

// Where an arrow at the end of a rod begins: a force that pushes ends at the rod, so that it does
// not hide it; one that pulls begins there.
export function atEnd([x, y], [bx, by], [dx, dy]) {
  const pushes = dx * (x - bx) + dy * (y - by) < 0;
  return pushes ? [x - dx, y - dy, dx, dy] : [x, y, dx, dy];
}

// Lines pass behind a text, not through it.
export function outlined(context, text, x, y, colours) {
  context.strokeStyle = colours.background;
  context.lineWidth = 4;
  context.lineJoin = "round";
  context.strokeText(text, x, y);
  context.fillText(text, x, y);
}

// The support at (x, y): a wall that holds a clamped rod, a triangle under a pinned one;
// (dx, dy): the direction of the rod there, in pixels.
export function support(context, kind, x, y, [dx, dy], colours) {
  if (!kind || kind === "free") return;
  context.save();
  context.translate(x, y);
  if (kind !== "pinned") context.rotate(Math.atan2(dy, dx) + Math.PI / 2);
  context.strokeStyle = colours.faint;
  context.fillStyle = colours.grid;
  context.lineWidth = 2;
  context.beginPath();
  if (kind === "pinned") {
    context.moveTo(-11, 18);
    context.lineTo(0, 0);
    context.lineTo(11, 18);
    context.closePath();
    context.fill();
    context.stroke();
    context.beginPath();
    hatch(context, 18);
  } else {
    hatch(context, 0);
  }
  context.restore();
}

// A line with hatching below it.
function hatch(context, y) {
  context.moveTo(-18, y);
  context.lineTo(18, y);
  context.stroke();
  context.lineWidth = 1;
  context.beginPath();
  for (let x = -18; x < 18; x += 6) {
    context.moveTo(x, y + 7);
    context.lineTo(x + 6, y);
  }
  context.stroke();
}
