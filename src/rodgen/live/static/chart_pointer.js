// Zoom by dragging, wheel and keys; the value nearest to the pointer.

import { act, listen, make, placeOf, turned } from "./dom.js";
import { short } from "./scales.js";

const NEAR = 30; // pixels from a curve that still tell its value
const LEAST = 8; // pixels that a drag must span

export class Gestures {
  #from = null; // where a drag began, in pixels of the box
  #over = null;

  constructor(card) {
    Object.assign(this, { card, chart: card.chart, box: card.box });
    const kind = card.spec.kind;
    this.plane = kind === "phase" || kind === "poincare";
    this.frame = make("div", { class: "rodgen-select", hidden: true });
    this.dot = make("div", { class: "rodgen-dot", hidden: true });
    this.hint = make("div", { class: "rodgen-hint", hidden: true });
    this.box.append(this.frame, this.dot, this.hint);
    this.box.tabIndex = 0;
    this.box.setAttribute("role", "img");
    this.box.setAttribute(
      "aria-label",
      `${card.spec.title}: drag, or plus, minus and arrows, to zoom; 0 resets`,
    );
    listen(this.box, {
      pointerdown: (event) => this.#press(event),
      pointermove: (event) => this.#move(event),
      pointerup: () => this.#release(),
      pointercancel: () => this.#leave(),
      pointerleave: () => this.#leave(),
      wheel: (event) => this.#wheel(event),
      keydown: (event) => this.#key(event),
      dblclick: () => card.zoom(null),
    });
  }

  #press(event) {
    if (event.button !== 0) return;
    this.#from = placeOf(event, this.box);
    this.box.setPointerCapture(event.pointerId);
  }

  #move(event) {
    this.#over = placeOf(event, this.box);
    if (this.#from) this.#select();
    else this.#tell();
  }

  // The part that is chosen, [left, top, right, bottom] in pixels; of a curve over x, all heights.
  #chosen() {
    const [a, b] = [this.#from, this.#over ?? this.#from];
    const { left, right, top, bottom } = this.chart.edges;
    const inside = (v, low, high) => Math.min(Math.max(v, low), high);
    const xs = [a[0], b[0]]
      .map((v) => inside(v, left, this.box.clientWidth - right))
      .sort((p, q) => p - q);
    const ends = [top, this.box.clientHeight - bottom];
    const ys = this.plane
      ? [a[1], b[1]].map((v) => inside(v, ...ends)).sort((p, q) => p - q)
      : ends;
    return [xs[0], ys[0], xs[1], ys[1]];
  }

  #select() {
    const [left, top, right, bottom] = this.#chosen();
    this.frame.hidden = right - left < LEAST;
    this.#untell();
    const size = { left, top, width: right - left, height: bottom - top };
    for (const [name, value] of Object.entries(size)) this.frame.style[name] = `${value}px`;
  }

  #release() {
    if (!this.#from || !this.chart.shown) return;
    const [left, top, right, bottom] = this.#chosen();
    this.#from = null;
    this.frame.hidden = true;
    if (right - left < LEAST || bottom - top < LEAST) return;
    const [x0, y1] = this.chart.value(left, top);
    const [x1, y0] = this.chart.value(right, bottom);
    this.card.zoom({ x: [x0, x1], y: this.plane ? [y0, y1] : null });
  }

  #leave() {
    this.#from = this.#over = null;
    this.frame.hidden = true;
    this.#untell();
  }

  // The wheel scrolls the page unless the plot was chosen (clicked) or Ctrl is held.
  #wheel(event) {
    if (!event.ctrlKey && document.activeElement !== this.box) return;
    event.preventDefault();
    this.#scale(Math.exp(0.0015 * turned(event)), placeOf(event, this.box));
  }

  // Spans times `factor` about a place in pixels.
  #scale(factor, place = [this.box.clientWidth / 2, this.box.clientHeight / 2]) {
    if (!this.chart.shown) return;
    const about = this.chart.value(...place);
    const { x, y } = this.chart.shown;
    const spread = (ends, k) => ends.map((end) => about[k] + factor * (end - about[k]));
    this.card.zoom({ x: spread(x, 0), y: this.plane ? spread(y, 1) : null });
  }

  #shift(share) {
    const { x, y } = this.chart.shown;
    const by = share * (x[1] - x[0]);
    this.card.zoom({ x: [x[0] + by, x[1] + by], y: this.plane ? y : null });
  }

  #key(event) {
    if (!this.chart.shown) return;
    act(event, {
      "+": () => this.#scale(0.8),
      "=": () => this.#scale(0.8),
      "-": () => this.#scale(1.25),
      0: () => this.card.zoom(null),
      ArrowLeft: () => this.#shift(-0.2),
      ArrowRight: () => this.#shift(0.2),
    });
  }

  // After a drawing: what is under the pointer may be another value.
  drawn() {
    if (this.#over && !this.#from) this.#tell();
  }

  #tell() {
    const found = this.#nearest(this.#over);
    this.dot.hidden = this.hint.hidden = !found;
    if (!found) return;
    const { spec } = this.card;
    const { px, py, x, y, k } = found;
    const one = spec.kind === "time" ? { unit: spec.y.unit, ...spec.series[k] } : spec.y;
    const told = (label, value, unit) => `${label} = ${short(value, 5)} ${unit ?? ""}`.trim();
    const lines = [told(one.label ?? one.name, y, one.unit), told(spec.x.label, x, spec.x.unit)];
    this.hint.textContent = lines.join("\n");
    this.dot.style.transform = `translate(${px}px, ${py}px)`;
    const right = px > this.box.clientWidth / 2;
    const shift = right ? " translateX(-100%)" : "";
    const beside = px + (right ? -10 : 10);
    this.hint.style.transform = `translate(${beside}px, ${Math.max(py - 40, 2)}px)${shift}`;
  }

  #untell() {
    this.dot.hidden = this.hint.hidden = true;
  }

  #nearest([ox, oy]) {
    let best = { distance: NEAR };
    (this.chart.shown?.curves ?? []).forEach((points, k) => {
      for (let at = 0; at < points.length; at += 2) {
        const [px, py] = this.chart.place(points[at], points[at + 1]);
        const distance = Math.hypot(px - ox, py - oy);
        if (distance < best.distance)
          best = { px, py, x: points[at], y: points[at + 1], k, distance };
      }
    });
    return best.px === undefined ? null : best;
  }
}
