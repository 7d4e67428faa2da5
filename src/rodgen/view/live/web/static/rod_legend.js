// The legend: colours of the bending moment, and what arrows are worth.

import { stops } from "./rod_links.js";
import { arrows } from "./rod_marks.js";
import { short } from "./numbers.js";
import { classes } from "./theme.js";

const ROW = 18;
const STEPS = 48;
const EDGE = 8;

// Where it stands, [x, y, width, height], in a picture of `width` pixels.
export function frame(width, moment, rows) {
  const wide = 204;
  return [width - wide - 6, 6, wide, (moment ? 52 : 8) + ROW * rows.length];
}

// moment: {limit, signed} or null; rows: [{name, colour, length (pixels), text}, ...].
export function legend(context, [, , wide, high], moment, rows, colours) {
  context.fillStyle = colours.panel;
  context.beginPath();
  context.roundRect(0, 0, wide, high, 6);
  context.fill();
  if (moment) colourBar(context, EDGE, wide - 2 * EDGE, moment, colours);
  let y = (moment ? 48 : 4) + ROW / 2;
  for (const row of rows) {
    arrows(context, [[EDGE, y, row.length, 0]], row.colour);
    context.fillStyle = colours.ink;
    context.textAlign = "left";
    context.textBaseline = "middle";
    context.fillText(`${row.name} ${row.text}`, EDGE + 52, y);
    y += ROW;
  }
}

function colourBar(context, left, wide, { limit, signed }, colours) {
  context.fillStyle = colours.ink;
  context.textAlign = "left";
  context.textBaseline = "top";
  context.fillText(signed ? "bending moment [N m]" : "|bending moment| [N m]", left, 6);
  const table = classes(stops(colours, signed), STEPS);
  const cell = wide / STEPS;
  table.forEach((colour, k) => {
    context.fillStyle = colour;
    context.fillRect(left + k * cell, 22, cell + 0.6, 9);
  });
  context.fillStyle = colours.ink;
  const ends = signed ? [-limit, 0, limit] : [0, limit / 2, limit];
  ["left", "center", "right"].forEach((align, k) => {
    context.textAlign = align;
    context.fillText(short(ends[k], 3), left + (k * wide) / 2, 34);
  });
}
