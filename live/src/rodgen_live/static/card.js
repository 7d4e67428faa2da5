// A plot in its frame: title, buttons, key of its curves, picture; and its files.

import { Chart, colours, entry, MANY } from "./chart.js";
import { Marks } from "./chart_marks.js";
import { Gestures } from "./chart_pointer.js";
import { Curves, PLANE, SEVERAL } from "./curves.js";
import { button, make, named, relabel, save } from "./dom.js";
import { theme } from "./theme.js";

export class Card {
  dirty = true;
  seen = false;
  drawn = -Infinity; // when, in milliseconds
  draws = 0;
  cost = 0; // of a drawing, in milliseconds

  // `on`: remove(), changed(), looked(time or null), zoomed(view), wrapped(whether),
  // picked(row); marks: gives values to mark, or nothing.
  constructor(spec, on) {
    Object.assign(this, { spec, on });
    this.curves = new Curves(spec);
    this.badge = make("span", { class: "rodgen-badge", "aria-live": "polite" });
    this.title = make("h3", { title: spec.title }, spec.title);
    this.key = make("div", { class: "rodgen-key" });
    this.box = make("div", { class: "rodgen-chart" });
    this.head = make("header", { draggable: "true" }, this.title, this.badge, this.#buttons());
    this.frame = make(
      "section",
      { class: "rodgen-plot", "aria-label": spec.title, "data-plot": spec.id },
      this.head,
      this.key,
      this.box,
    );
  }

  #buttons() {
    const { title } = this.spec;
    this.hold = button("pause", `Pause ${title}`, () => this.pause(!this.curves.paused));
    this.reset = button("zoom_out_map", `Reset zoom of ${title}`, () => this.zoom(null));
    this.reset.disabled = true;
    return make(
      "div",
      { class: "rodgen-buttons" },
      ...this.#turns(),
      this.hold,
      this.reset,
      button("image", `Save ${title} as PNG`, () => this.png()),
      button("table_view", `Save ${title} as CSV`, () => this.csv()),
      button("close", `Remove ${title}`, () => this.on.remove()),
    );
  }

  // Shows angles without their whole turns, or as they are.
  #turns() {
    const { title, series, x } = this.spec;
    if (![x, ...series].some(({ turn }) => turn)) return [];
    const said = `Leave out whole turns of ${title}`;
    const onclick = () => {
      this.wrap(!this.curves.wrapped);
      this.on.wrapped(this.curves.wrapped);
    };
    const of = { type: "button", "aria-label": said, title: said, onclick };
    this.fold = make("button", { ...of, "aria-pressed": String(this.curves.wrapped) }, "±π");
    return [this.fold];
  }

  wrap(wrapped) {
    if (wrapped === this.curves.wrapped) return;
    this.curves.wrap(wrapped);
    this.fold?.setAttribute("aria-pressed", String(wrapped));
    this.changed();
  }

  // Once it stands in the page, where it has a size.
  open() {
    this.chart = new Chart(this.box, this.spec, {
      zoom: (view) => this.zoom(view),
      looked: (t) => this.looked(t),
    });
    this.gestures = new Gestures(this);
    this.marks = new Marks(this.chart, this.on.marks);
    this.chart.plot.over.addEventListener("click", () => {
      if (this.spec.kind === "sweep" && this.chart.found !== null) this.on.picked(this.chart.found);
    });
    this.sizes = new ResizeObserver(() => {
      this.chart.resize();
      this.changed();
    });
    this.sizes.observe(this.box);
    this.sight = new IntersectionObserver((entries) => {
      this.seen = entries.at(-1).isIntersecting;
      if (this.dirty) this.on.changed();
    });
    this.sight.observe(this.box);
    this.#legend();
  }

  close() {
    this.sizes?.disconnect();
    this.sight?.disconnect();
    this.chart?.dispose();
    this.frame.remove();
  }

  changed() {
    this.dirty = true;
    this.on.changed();
  }

  take(values, replace) {
    this.curves.take(values, replace);
    if (!this.curves.still) this.dirty = true;
  }

  restart() {
    this.curves.restart();
    this.#settled();
  }

  // The pointer is at another place of the picture: all others show what was then.
  looked(t) {
    this.gestures.tell();
    this.on.looked(t);
  }

  // pointed: a pointer is over some plot.
  look(t, pointed) {
    this.pointed = pointed;
    this.chart.look(t);
    this.gestures.tell();
  }

  // Has a time [s] of the past in its window; null: the present.
  turn(t) {
    // A curve does not end where a pointer on it looks.
    if (this.curves.turn(this.chart.led && this.curves.plane ? null : t)) this.dirty = true;
    this.marks.show();
  }

  compare(rows) {
    this.curves.compare(rows);
    this.#legend();
    this.dirty = true;
  }

  draw(now) {
    const begin = performance.now();
    this.chart.draw(this.curves.now(now));
    this.gestures.tell();
    this.marks.show();
    Object.assign(this, { dirty: false, drawn: now });
    this.draws += 1;
    this.cost += 0.3 * (performance.now() - begin - this.cost);
  }

  restyle() {
    this.#legend();
    this.dirty = true;
  }

  #legend() {
    const kept = this.curves.ghost.length > 0;
    const sign = () => make("i", { class: "rodgen-kept", "aria-hidden": "true" });
    const beside = kept ? [make("span", {}, sign(), keptOf(this.spec))] : [];
    this.key.replaceChildren(...this.#names(), ...beside);
  }

  // Up to eight curves by name, more by the ends of the colour map.
  #names() {
    const shades = colours(this.spec);
    const { series, kind } = this.spec;
    if (!SEVERAL.includes(kind) || series.length < 2) return [];
    const words = series.map((one) => entry(this.spec, one));
    if (series.length <= MANY) {
      const line = (colour) => make("i", { style: `background:${colour}`, "aria-hidden": "true" });
      return words.map((text, k) => make("span", {}, line(shades[k]), text));
    }
    const ramp = make("i", {
      class: "rodgen-ramp",
      style: `background:linear-gradient(90deg,${shades})`,
    });
    const ends = [words[0], words.at(-1)].map((text) => make("span", {}, text));
    return [ends[0], ramp, ends[1]];
  }

  pause(paused) {
    this.curves.pause(paused);
    relabel(
      this.hold,
      paused ? "play_arrow" : "pause",
      `${paused ? "Resume" : "Pause"} ${this.spec.title}`,
    );
    this.hold.setAttribute("aria-pressed", String(paused));
    this.#settled();
  }

  // Somebody zooms: view, {x: [low, high], y: [low, high] or null}; null for all.
  zoom(view) {
    this.show(view);
    this.on.zoomed(view);
  }

  show(view) {
    this.curves.zoom(view);
    this.reset.disabled = view === null;
    this.#settled();
  }

  #settled() {
    const { paused, view, former } = this.curves;
    const words = [paused ? "paused" : view ? "zoomed" : "", former ? "run before" : ""];
    this.badge.textContent = words.filter((word) => word).join(", ");
    this.changed();
  }

  async png() {
    if (this.dirty) this.draw(performance.now());
    const kept = this.curves.ghost.length > 0;
    picture(this.spec, await this.chart.picture(), kept).toBlob((blob) =>
      save(blob, named(this.spec.title, "png")),
    );
  }

  csv() {
    const text = csv(this.spec, this.curves.shown, this.curves.end);
    save(new Blob([text], { type: "text/csv" }), named(this.spec.title, "csv"));
  }
}

// How the run that is kept is drawn.
const keptOf = ({ kind }) => `${kind === "poincare" ? "rings" : "dashed"}: the run that is kept`;

// Rows of a plot as text: a header with names and units, then every row that is kept, up to `end`.
const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
const titled = (name, unit) => quoted(unit ? `${name} [${unit}]` : name);

const TIME = { label: "t", unit: "s" };

function csv(spec, rows, end) {
  const curves = spec.series.map(({ name, unit }) => ({ label: name, unit: unit ?? spec.y.unit }));
  const plane = PLANE.includes(spec.kind) ? [TIME] : [];
  const columns = SEVERAL.includes(spec.kind) ? [spec.x, ...curves] : [...plane, spec.x, spec.y];
  const head = columns.map(({ label, unit }) => titled(label, unit));
  const lines = [head.join(",")];
  for (let row = rows.first; row < end; row++) {
    // The shortest text that gives the same double again.
    lines.push(Array.from({ length: rows.columns }, (_, k) => String(rows.at(row, k))).join(","));
  }
  return lines.join("\n") + "\n";
}

// The picture of a plot with its title and key, as it is saved.
const DENSE = 2;
const FONT = "Roboto, system-ui, sans-serif";
const SMALL = `12px ${FONT}`;

// `chart`: a canvas with the picture at twice its size; kept: whether a run that is kept is in it;
// a canvas.
function picture(spec, chart, kept) {
  const listed = spec.series.length > 1 && spec.series.length <= MANY && SEVERAL.includes(spec.kind);
  const top = (listed || kept ? 50 : 30) * DENSE;
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
  const end = listed ? key(context, spec) : 12;
  context.font = SMALL;
  if (kept) context.fillText(keptOf(spec), end, 42);
  return canvas;
}

// Returns where it ends.
function key(context, spec) {
  context.font = SMALL;
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
  return x;
}
