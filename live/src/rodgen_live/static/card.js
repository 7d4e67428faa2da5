// A plot in its frame: title, buttons, key of its curves, picture; and its files.

import { axisName, Chart, colours, entry, MANY } from "./chart.js";
import { Gestures } from "./chart_pointer.js";
import { Curves } from "./curves.js";
import { button, make, named, relabel, save } from "./dom.js";
import { hub } from "./hub.js";
import { theme } from "./theme.js";

export class Card {
  dirty = true;
  seen = false;
  drawn = -Infinity; // when, in milliseconds
  draws = 0;
  cost = 0; // of a drawing, in milliseconds
  swept = null; // values that are marked in a sweep

  // `plots`: the component that it is a part of.
  constructor(spec, plots) {
    Object.assign(this, { spec, plots });
    this.curves = new Curves(spec);
    this.badge = make("span", { class: "rodgen-badge", "aria-live": "polite" });
    this.key = make("div", { class: "rodgen-key" });
    this.box = make("div", { class: "rodgen-chart" });
    const title = make("h3", { title: spec.title }, spec.title);
    const head = make("header", { draggable: "true" }, title, this.badge, this.#buttons());
    const of = { class: "rodgen-plot", "aria-label": spec.title, "data-plot": spec.id };
    this.frame = make("section", of, head, this.key, this.box);
  }

  #buttons() {
    const { title, id, series, x } = this.spec;
    const turns = `Leave out whole turns of ${title}`;
    this.fold = button("±π", turns, () => {
      this.wrap(!this.curves.wrapped);
      this.plots.$emit("wrapped", { id, wrapped: this.curves.wrapped });
    });
    this.fold.setAttribute("aria-pressed", this.curves.wrapped);
    this.hold = button("pause", `Pause ${title}`, () => this.pause(!this.curves.paused));
    const whole = () => this.plots.zoom(this, null);
    this.reset = button("zoom_out_map", `Reset zoom of ${title}`, whole);
    this.reset.disabled = true;
    return make(
      "div",
      { class: "rodgen-buttons" },
      ...([x, ...series].some(({ turn }) => turn) ? [this.fold] : []),
      this.hold,
      this.reset,
      button("image", `Save ${title} as PNG`, () => this.png()),
      button("table_view", `Save ${title} as CSV`, () => this.csv()),
      button("close", `Remove ${title}`, () => this.plots.remove(id)),
    );
  }

  // Shows angles without their whole turns, or as they are.
  wrap(wrapped) {
    if (wrapped === this.curves.wrapped) return;
    this.curves.wrap(wrapped);
    this.fold.setAttribute("aria-pressed", wrapped);
    this.#changed();
  }

  // Once it stands in the page, where it has a size.
  open() {
    this.chart = new Chart(this.box, this.spec, {
      zoom: (view) => this.plots.zoom(this, view),
      looked: (t) => {
        this.gestures.tell();
        this.plots.point(t, this);
      },
    });
    this.gestures = new Gestures(this);
    this.chart.plot.over.addEventListener("click", () => {
      const { kind, id } = this.spec;
      const { found: row } = this.chart;
      if (kind === "sweep" && row !== null) this.plots.$emit("picked", { id, row });
    });
    this.sizes = new ResizeObserver(() => {
      this.chart.resize();
      this.#changed();
    });
    this.sizes.observe(this.box);
    this.sight = new IntersectionObserver((entries) => {
      this.seen = entries.at(-1).isIntersecting;
      if (this.dirty) hub.repaint();
    });
    this.sight.observe(this.box);
    this.restyle();
  }

  close() {
    this.sizes.disconnect();
    this.sight.disconnect();
    this.chart.dispose();
    this.frame.remove();
  }

  #changed() {
    this.dirty = true;
    hub.repaint();
  }

  take(values, replace) {
    this.curves.take(values, replace);
    if (!this.curves.paused) this.dirty = true;
  }

  restart() {
    this.curves.restart();
    this.#settled();
  }

  // All plots show what was at a time that is looked at in one of them.
  look(t) {
    this.chart.look(t);
    this.gestures.tell();
  }

  // Has a time [s] of the past in its window; null: the present.
  turn(t) {
    // A curve does not end where a pointer on it looks.
    const moved = this.curves.turn(this.chart.led && this.curves.plane ? null : t);
    if (moved || this.marks !== hub.past.marks) this.dirty = true;
  }

  compare(rows) {
    this.curves.compare(rows);
    this.restyle();
  }

  draw(now) {
    const begin = performance.now();
    const { kind } = this.spec;
    this.marks = hub.past.marks;
    const changes = kind === "time" ? this.marks.map(([t]) => [t, ""]) : [];
    this.chart.draw({ ...this.curves.now(now), marks: this.swept ?? changes });
    this.gestures.tell();
    Object.assign(this, { dirty: false, drawn: now });
    this.draws += 1;
    this.cost += 0.3 * (performance.now() - begin - this.cost);
  }

  restyle() {
    const entries = this.#entries.map(([colour, words]) => {
      const sign = colour ? { style: `background:${colour}` } : { class: "rodgen-kept" };
      return make("span", {}, make("i", sign), words);
    });
    this.key.replaceChildren(...entries);
    this.dirty = true;
  }

  // What the key says: [colour, words] of each of some curves, of more the first and the last; and
  // how the run that is kept is drawn.
  get #entries() {
    const { series, kind } = this.spec;
    const shades = colours(this.spec);
    const every = series.map((one, k) => [shades[k], entry(this.spec, one)]);
    const some = every.length > MANY ? [every[0], every.at(-1)] : every;
    const drawn = kind === "poincare" ? "rings" : "dashed";
    const kept = this.curves.ghost.length ? [[null, `${drawn}: the run that is kept`]] : [];
    return [...(every.length > 1 ? some : []), ...kept];
  }

  pause(paused) {
    const words = `${paused ? "Resume" : "Pause"} ${this.spec.title}`;
    this.curves.pause(paused);
    relabel(this.hold, paused ? "play_arrow" : "pause", words);
    this.hold.setAttribute("aria-pressed", paused);
    this.#settled();
  }

  // A part of it, {x: [low, high], y: [low, high] or null}; null for all.
  show(view) {
    this.curves.view = view;
    this.reset.disabled = view === null;
    this.#settled();
  }

  #settled() {
    const { paused, view, former } = this.curves;
    const words = [paused ? "paused" : view ? "zoomed" : "", former ? "run before" : ""];
    this.badge.textContent = words.filter((word) => word).join(", ");
    this.#changed();
  }

  async png() {
    if (this.dirty) this.draw(performance.now());
    const { title } = this.spec;
    const canvas = picture(title, this.#entries, await this.chart.picture());
    canvas.toBlob((blob) => save(blob, named(title, "png")));
  }

  csv() {
    const text = csv(this.spec, this.curves);
    save(new Blob([text], { type: "text/csv" }), named(this.spec.title, "csv"));
  }
}

// Rows of a plot as text: a header with names and units, then every row that is kept.
function csv({ x, y, series }, { plane, shown: rows, end }) {
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const curves = series.map(({ name, unit = y.unit }) => ({ label: name, unit }));
  const columns = [...(plane ? [{ label: "t", unit: "s" }] : []), x, ...curves];
  const lines = [columns.map((column) => quoted(axisName(column))).join(",")];
  for (let row = rows.first; row < end; row++) {
    // The shortest text that gives the same double again.
    lines.push(columns.map((_, k) => String(rows.at(row, k))).join(","));
  }
  return lines.join("\n") + "\n";
}

// The picture of a plot with its title and key, as it is saved; chart: a canvas with its curves.
const DENSE = 2; // pixels of that for one of the page
const FONT = "Roboto, system-ui, sans-serif";

function picture(title, entries, chart) {
  const top = (entries.length ? 50 : 30) * DENSE;
  const canvas = make("canvas", { width: chart.width, height: chart.height + top });
  const context = canvas.getContext("2d");
  const { background, ink } = theme();
  context.fillStyle = background;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.drawImage(chart, 0, top);
  context.scale(DENSE, DENSE);
  context.fillStyle = ink;
  context.font = `500 14px ${FONT}`;
  context.fillText(title, 12, 20);
  context.font = `12px ${FONT}`;
  let x = 12;
  for (const [colour, words] of entries) {
    const sign = colour ? 18 : 0;
    context.fillStyle = colour ?? background;
    context.fillRect(x, 36, sign && 14, 3);
    context.fillStyle = ink;
    context.fillText(words, x + sign, 42);
    x += sign + 14 + context.measureText(words).width;
  }
  return canvas;
}
