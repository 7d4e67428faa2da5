// The grid on the ground with numbers in metres, and a bar that tells the scale.

import { line } from "./rod_links.js";
import { outlined } from "./rod_marks.js";
import { above, base, multiples, short, written } from "./scales.js";

const SPACING = 55; // pixels between lines, at least

// Draws in the frame of the world; `camera` turns it where the view turns.
export function grid(context, camera, origin, colours) {
  const step = above(SPACING / camera.scale);
  const box = seen(camera);
  // Absolute coordinates, in doubles; near the origin of the state differences are exact enough.
  const columns = multiples(origin[0] + box[0], origin[0] + box[2], step);
  const rows = multiples(origin[1] + box[1], origin[1] + box[3], step);
  const lines = [
    ...columns.map((k) => [k * step - origin[0], box[1], k * step - origin[0], box[3], k]),
    ...rows.map((k) => [box[0], k * step - origin[1], box[2], k * step - origin[1], k]),
  ];
  context.lineWidth = 1;
  for (const [colour, through] of [
    [colours.grid, false],
    [colours.axis, true],
  ]) {
    context.strokeStyle = colour;
    context.beginPath();
    for (const [x1, y1, x2, y2, k] of lines) {
      if ((k === 0) !== through) continue;
      context.moveTo(...camera.screen(x1, y1));
      context.lineTo(...camera.screen(x2, y2));
    }
    context.stroke();
  }
  if (camera.mode === "axes") compass(context, camera, colours);
  else labels(context, camera, origin, { columns, rows, step, box }, colours);
  bar(context, camera, step, colours);
}

// What the picture shows, [left, bottom, right, top] from the origin of the state.
function seen(camera) {
  const corners = [
    [0, 0],
    [camera.width, 0],
    [0, camera.height],
    [camera.width, camera.height],
  ];
  const points = corners.map(([px, py]) => camera.world(px, py));
  const [xs, ys] = [points.map((p) => p[0]), points.map((p) => p[1])];
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}

function labels(context, camera, origin, { columns, rows, step, box }, colours) {
  const { faint: fillStyle } = colours;
  const [fromX, fromY] = [0, 1].map((k) => base(origin[k] + box[k], origin[k] + box[k + 2], step));
  Object.assign(context, { fillStyle, textAlign: "center", textBaseline: "bottom" });
  for (const k of columns) {
    const [x] = camera.screen(k * step - origin[0], 0);
    if (x > 46 && x < camera.width - 24) {
      outlined(context, written(k * step - fromX, step), x, camera.height - 4, colours);
    }
  }
  Object.assign(context, { textAlign: "left", textBaseline: "middle" });
  for (const k of rows) {
    const [, y] = camera.screen(0, k * step - origin[1]);
    if (y > 28 && y < camera.height - 26) {
      outlined(context, written(k * step - fromY, step), 6, y, colours);
    }
  }
  context.textBaseline = "bottom";
  const offsets = [
    ["x", fromX],
    ["y", fromY],
  ].filter(([, from]) => from !== 0);
  const names = offsets.map(([axis, from]) => `${axis} from ${short(from, 15)} m`);
  outlined(context, "m", 6, camera.height - 4, colours);
  outlined(context, names.join(", "), 36, camera.height - 20, colours);
}

// Where x and y point in a view that turns.
function compass(context, camera, colours) {
  const [x, y] = [44, camera.height - 44];
  const { faint: fillStyle } = colours;
  Object.assign(context, { fillStyle, textAlign: "center", textBaseline: "middle" });
  for (const [name, ex, ey] of [
    ["x", 1, 0],
    ["y", 0, 1],
  ]) {
    const [dx, dy] = camera.direction(ex, ey);
    line(context, [x, y, x + 22 * dx, y + 22 * dy], fillStyle, 1.5);
    context.fillText(name, x + 31 * dx, y + 31 * dy);
  }
}

function bar(context, camera, step, colours) {
  const length = step * camera.scale;
  const [right, y] = [camera.width - 12, camera.height - 26];
  const left = right - length;
  line(context, [left, y - 4, left, y, right, y, right, y - 4], colours.ink, 2);
  const { ink: fillStyle } = colours;
  Object.assign(context, { fillStyle, textAlign: "center", textBaseline: "bottom" });
  context.fillText(`${short(step)} m`, right - length / 2, y - 4);
}
