// The legend: colours of the bending moment, and what arrows are worth.

import { arrows } from "./rod_marks.js";
import { short } from "./numbers.js";
import { classes } from "./theme.js";

const ROW = 18;
const STEPS = 48;
const EDGE = 8;

// Where it stands, [x, y, width, height], in a picture of `width` pixels: with so many rows, with
// or without colours.
export function frame(width, coloured, rows) {
  const wide = 204;
  return [width - wide - 6, 6, wide, (coloured ? 52 : 8) + ROW * rows];
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
    context.fillStyle = colours.ink;
    context.textAlign = "left";
    context.textBaseline = "middle";
    context.fillText(`${row.name} ${row.text}`, EDGE + 52, y);
    y += ROW;
  }
}

function colourBar(context, left, wide, limit, colours) {
  context.fillStyle = colours.ink;
  context.textAlign = "left";
  context.textBaseline = "top";
  context.fillText("bending moment [N m]", left, 6);
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
