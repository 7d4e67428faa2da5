// Zoom by wheel, keys and touch; the values that are looked at, in words.

import { act, listen, make, placeOf, tell, turned } from "./dom.js";
import { MANY } from "./chart.js";
import { nearest } from "./rows.js";
import { short } from "./scales.js";

const MOUSE = { pointerdown: "mousedown", pointermove: "mousemove", pointerup: "mouseup" };

export class Gestures {
  constructor(card) {
    Object.assign(this, { card, chart: card.chart, box: card.box });
    this.over = this.chart.plot.over;
    this.hint = make("div", { class: "rodgen-hint", hidden: true });
    this.over.append(this.hint);
    this.box.tabIndex = 0;
    this.box.setAttribute("role", "img");
    this.box.setAttribute(
      "aria-label",
      `${card.spec.title}: drag, or plus, minus and arrows, to zoom; 0 resets`,
    );
    listen(this.box, {
      wheel: (event) => this.#wheel(event),
      keydown: (event) => this.#key(event),
    });
    for (const [name, mouse] of Object.entries(MOUSE))
      this.over.addEventListener(name, (event) => this.#touch(event, mouse));
  }

  // uPlot knows the mouse alone; a finger drags like it.
  #touch(event, name) {
    if (event.pointerType !== "touch") return;
    const { clientX, clientY, movementX } = event;
    const like = { clientX, clientY, movementX: movementX || 1, bubbles: true };
    this.over.dispatchEvent(new MouseEvent(name, like));
  }

  // The wheel scrolls the page unless the plot was chosen (clicked) or Ctrl is held.
  #wheel(event) {
    if (!event.ctrlKey && document.activeElement !== this.box) return;
    event.preventDefault();
    this.#scale(Math.exp(0.0015 * turned(event)), placeOf(event, this.over));
  }

  // Shows what lies in a part of the picture, in pixels, which may reach beyond it.
  #show([left, right], [top, bottom]) {
    const [x0, y1] = this.chart.value(left, top);
    const [x1, y0] = this.chart.value(right, bottom);
    this.card.plots.zoom(this.card, { x: [x0, x1], y: this.chart.plane ? [y0, y1] : null });
  }

  // Spans times `factor` about a place in pixels.
  #scale(factor, place = [this.over.clientWidth / 2, this.over.clientHeight / 2]) {
    const sizes = [this.over.clientWidth, this.over.clientHeight];
    this.#show(...sizes.map((size, k) => [0, size].map((end) => place[k] + factor * (end - place[k]))));
  }

  #shift(share) {
    const { clientWidth, clientHeight } = this.over;
    this.#show([share * clientWidth, (1 + share) * clientWidth], [0, clientHeight]);
  }

  #key(event) {
    act(event, {
      "+": () => this.#scale(0.8),
      "=": () => this.#scale(0.8),
      "-": () => this.#scale(1.25),
      0: () => this.card.plots.zoom(this.card, null),
      ArrowLeft: () => this.#shift(-0.2),
      ArrowRight: () => this.#shift(0.2),
    });
  }

  // Says the values at what a pointer is at, beside it; of what the time line is at there is a line
  // alone, lest words lie over the curves all the time.
  tell() {
    const { found, shown, led } = this.chart;
    const seen = found !== null && (led || this.card.plots.pointed !== null);
    const lines = seen ? this.#lines(found, shown) : [];
    tell(this.hint, lines, [seen ? this.chart.place(shown.across[found], 0)[0] : 0, 0]);
  }

  #lines(row, { times, across, up, ghost }) {
    const { spec } = this.card;
    const said = ({ label, unit }, value) => `${label} = ${short(value, 5)} ${unit ?? ""}`.trim();
    const some = up.length > MANY ? [this.#nearest(row, up)] : [...up.keys()];
    const seen = some.filter((k) => spec.kind !== "sweep" || Number.isFinite(up[k][row]));
    const kept = spec.kind === "time" ? beside(ghost, across[row]) : null;
    const values = seen.map((k) => {
      const { name, label = name, unit } = spec.series[k];
      const other = kept === null ? "" : ` (kept: ${short(ghost.up[k][kept], 5)})`;
      return said({ label, unit: unit ?? spec.y.unit }, up[k][row]) + other;
    });
    const time = times && this.chart.plane ? [said({ label: "t", unit: "s" }, times[row])] : [];
    return [said(spec.x, across[row]), ...values, ...time];
  }

  // Of many curves, the one at the cursor.
  #nearest(row, up) {
    const { top } = this.chart.plot.cursor;
    const away = up.map((values) => Math.abs(this.chart.place(0, values[row])[1] - top));
    return away.indexOf(Math.min(...away));
  }
}

// The row of the run that is kept at a time, null where that has none.
function beside({ across }, t) {
  return across.length && across[0] <= t && t <= across.at(-1) ? nearest(across, t) : null;
}
