// What stands by the rod: bodies, centre of gravity, principal axes, arrows; and the legend, with the
// colours of the bending moment and what arrows are worth.

import { short } from "./scales.js";
import { classes } from "./theme.js";

const TURN = 2 * Math.PI;
const [ROW, EDGE, NAME, LEAST_WIDE] = [18, 8, 60, 204]; // pixels of the legend; NAME: before names
const VALUE = ", scale 0.00 m/s\u00b2"; // as wide as most
const BESIDE = 14; // pixels from an end to its name
const LYING = 0.4; // the sine of a link's angle, below which it lies
const STEPS = 48; // of the colours of the bending moment
const RADIUS = 20; // pixels, of the arrows of couples
const LARGEST_BODY = 18; // pixels, the radius of a body that is the whole mass
const MOST_NAMES = 8; // of bodies

// The quartered circle.
export function centre(context, x, y, colours) {
  const radius = 8;
  Object.assign(context, { strokeStyle: colours.centre, lineWidth: 1.5 });
  context.fillStyle = colours.background;
  disc(context, x, y, radius);
  context.fillStyle = colours.centre;
  for (const begin of [0, Math.PI]) {
    context.beginPath();
    context.moveTo(x, y);
    context.arc(x, y, radius, begin, begin + TURN / 4);
    context.fill();
  }
}

// Filled, and with an edge.
function disc(context, x, y, radius) {
  context.beginPath();
  context.arc(x, y, radius, 0, TURN);
  context.fill();
  context.stroke();
}

// Both principal axes through (x, y); (dx, dy) is the direction of the first, in pixels.
export function axes(context, x, y, [dx, dy], colours) {
  const size = Math.hypot(dx, dy) || 1;
  const [c, s] = [dx / size, dy / size];
  context.strokeStyle = context.fillStyle = colours.centre;
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
  Object.assign(context, { textAlign: "center", textBaseline: "middle" });
  context.fillText("1", x + c * 100, y + s * 100);
  context.fillText("2", x + s * 70, y - c * 70);
}

// Arrows [x, y, dx, dy] in pixels, from (x, y); those of a kind in one stroke and one fill.
export function arrows(context, list, colour, width = 2) {
  const head = 2 + 2.6 * width;
  Object.assign(context, { strokeStyle: colour, fillStyle: colour, lineWidth: width });
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

// Curved arrows [x, y, length] in pixels about (x, y), to the left where the length is above zero.
export function curved(context, list, colour, width = 2) {
  Object.assign(context, { strokeStyle: colour, lineWidth: width });
  for (const [x, y, length] of list) {
    const head = Math.sign(length) * Math.min(Math.abs(length) / RADIUS, 0.4);
    const end = TURN / 8 - length / RADIUS + head; // where the head begins
    const [dx, dy] = [Math.cos(end) * RADIUS, Math.sin(end) * RADIUS];
    context.beginPath();
    context.arc(x, y, RADIUS, TURN / 8, end, length > 0);
    context.stroke();
    arrows(context, [[x + dx, y + dy, dy * head, -dx * head]], colour, width);
  }
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

// Bodies {name, link, along, across, size} as discs, their areas by their masses, and their names
// unless these would be many; points: joints in pixels, whose y runs down.
export function bodies(context, points, list, colours) {
  for (const { name, link, along, across, size } of list) {
    if (2 * link + 4 > points.length) continue; // the rod before
    const [ax, ay, bx, by] = points.subarray(2 * link, 2 * link + 4);
    const [dx, dy] = [bx - ax, by - ay];
    const place = [ax + along * dx + across * dy, ay + along * dy - across * dx];
    const radius = Math.max(LARGEST_BODY * size, 2);
    Object.assign(context, { fillStyle: colours.body, strokeStyle: colours.edge, lineWidth: 1.2 });
    disc(context, ...place, radius);
    context.fillStyle = colours.ink;
    // On the other side than the names of the ends.
    const side = beside([dx, dy]).map((part) => -part);
    if (list.length <= MOST_NAMES) put(context, name, place, side, radius + 9, colours);
  }
}

// What the ends are called, beside them; first: the name of the one that the rod begins with.
export function ends(context, points, first, colours) {
  context.fillStyle = colours.faint;
  const [x0, y0, x1, y1] = points;
  for (const [name, x, y, bx, by] of [
    [first, x0, y0, x1, y1],
    ["tail", ...points.slice(-2), ...points.slice(-4, -2)],
  ]) {
    put(context, name, [x, y], beside([x - bx, y - by]), BESIDE, colours);
  }
}

// Where names stand beside a link, as a direction: across it, as along it arrows of forces may
// stand; above a link that lies, else to the right.
function beside([x, y]) {
  const size = Math.hypot(x, y) || 1;
  const [dx, dy] = [y / size, -x / size];
  const other = Math.abs(dx) < LYING ? dy > 0 : dx < 0;
  return other ? [-dx, -dy] : [dx, dy];
}

function put(context, name, [x, y], [dx, dy], away, colours) {
  const lies = Math.abs(dx) < LYING;
  context.textBaseline = "middle";
  context.textAlign = lies ? "center" : dx > 0 ? "left" : "right";
  outlined(context, name, x + dx * away, y + dy * away, colours);
}

// Where the legend stands, [x, y, width, height], in a picture of `width` pixels: with rows of such
// names, with or without colours.
export function frame(context, width, coloured, names) {
  const texts = names.map((name) => NAME + context.measureText(`${name}${VALUE}`).width + EDGE);
  const wide = Math.ceil(Math.max(LEAST_WIDE, ...texts));
  return [width - wide - 6, 6, wide, (coloured ? 52 : 8) + ROW * names.length];
}

// limit: the end of the scale of moments, 0 for none; rows: [{name, colour, length (pixels), text},
// ...].
export function legend(context, [, , wide, high], limit, rows, colours) {
  context.fillStyle = colours.panel;
  context.beginPath();
  context.roundRect(0, 0, wide, high, 6);
  context.fill();
  if (limit) colourBar(context, EDGE, wide - 2 * EDGE, limit, colours);
  let y = (limit ? 48 : 4) + ROW / 2;
  for (const row of rows) {
    arrows(context, [[EDGE, y, row.length, 0]], row.colour);
    Object.assign(context, { fillStyle: colours.ink, textAlign: "left", textBaseline: "middle" });
    context.fillText(`${row.name}, ${row.text}`, NAME, y);
    y += ROW;
  }
}

function colourBar(context, left, wide, limit, colours) {
  Object.assign(context, { fillStyle: colours.ink, textAlign: "left", textBaseline: "top" });
  context.fillText("bending moment [N m], \u221a scale", left, 6);
  const table = classes(colours.moments, STEPS);
  const cell = wide / STEPS;
  table.forEach((colour, k) => {
    context.fillStyle = colour;
    context.fillRect(left + k * cell, 22, cell + 0.6, 9);
  });
  context.fillStyle = colours.ink;
  ["left", "center", "right"].forEach((align, k) => {
    context.textAlign = align;
    context.fillText(short((k - 1) * limit, 3), left + (k * wide) / 2, 34);
  });
}
