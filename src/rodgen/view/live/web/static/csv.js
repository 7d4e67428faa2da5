// Rows of a plot as text: a header with names and units, then every row that is kept, up to `end`.

import { PLANE } from "./curves.js";

const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
const titled = (name, unit) => quoted(unit ? `${name} [${unit}]` : name);

const TIME = { label: "t", unit: "s" };

export function csv(spec, rows, end) {
  const curves = spec.series.map(({ name, unit }) => ({ label: name, unit: unit ?? spec.y.unit }));
  const plane = PLANE.includes(spec.kind) ? [TIME] : [];
  const columns = spec.kind === "time" ? [spec.x, ...curves] : [...plane, spec.x, spec.y];
  const head = columns.map(({ label, unit }) => titled(label, unit));
  const lines = [head.join(",")];
  for (let row = rows.first; row < end; row++) {
    // The shortest text that gives the same double again.
    lines.push(Array.from({ length: rows.columns }, (_, k) => String(rows.at(row, k))).join(","));
  }
  return lines.join("\n") + "\n";
}
