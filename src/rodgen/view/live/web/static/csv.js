// Rows of a plot as text: a header with names and units, then every row that is kept.

const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
const titled = (name, unit) => quoted(unit ? `${name} [${unit}]` : name);

export function csv(spec, rows) {
  // Only over time there is a column for each series.
  const columns =
    spec.kind === "time"
      ? spec.series.map(({ name, unit }) => [name, unit ?? spec.y.unit])
      : [[spec.y.label, spec.y.unit]];
  const head = [[spec.x.label, spec.x.unit], ...columns].map(([name, unit]) => titled(name, unit));
  const lines = [head.join(",")];
  for (let row = rows.first; row < rows.total; row++) {
    // The shortest text that gives the same double again.
    lines.push(Array.from({ length: rows.columns }, (_, k) => String(rows.at(row, k))).join(","));
  }
  return lines.join("\n") + "\n";
}
