// The picture of a plot with its title and key, as it is saved.

import { colours, entry, MANY } from "./chart.js";
import { theme } from "./theme.js";

const DENSE = 2;
const FONT = "Roboto, system-ui, sans-serif";

// `chart`: a canvas with the picture at twice its size; a canvas.
export function picture(spec, chart) {
  const listed = spec.series.length > 1 && spec.series.length <= MANY && spec.kind === "time";
  const top = (listed ? 50 : 30) * DENSE;
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width: chart.width, height: chart.height + top });
  const context = canvas.getContext("2d");
  context.fillStyle = theme().background;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.drawImage(chart, 0, top);
  context.scale(DENSE, DENSE);
  context.fillStyle = theme().ink;
  context.font = `500 14px ${FONT}`;
  context.fillText(spec.title, 12, 20);
  if (listed) key(context, spec);
  return canvas;
}

function key(context, spec) {
  context.font = `12px ${FONT}`;
  const shades = colours(spec);
  let x = 12;
  spec.series.forEach((one, k) => {
    const label = entry(spec, one);
    context.fillStyle = shades[k];
    context.fillRect(x, 36, 14, 3);
    context.fillStyle = theme().ink;
    context.fillText(label, x + 18, 42);
    x += 32 + context.measureText(label).width;
  });
}
