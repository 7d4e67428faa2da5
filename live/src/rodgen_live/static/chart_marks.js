// Lines in a plot over time where the run was changed or kicked.

import { make } from "./dom.js";
import { hub } from "./hub.js";

export class Marks {
  #places = [];

  constructor(chart) {
    this.chart = chart;
    this.box = make("div", { class: "rodgen-marks", "aria-hidden": "true" });
    chart.plot.over.append(this.box);
  }

  show() {
    const { chart } = this;
    if (chart.spec.kind !== "time") return;
    const [from, to] = chart.shown.x;
    const seen = hub.past.marks.filter(([t]) => t >= from && t <= to);
    const places = seen.map(([t]) => Math.round(chart.place(t, 0)[0]));
    if (places.join() === this.#places.join()) return;
    this.#places = places;
    this.box.replaceChildren(...places.map((x) => make("i", { style: `left:${x}px` })));
  }
}
