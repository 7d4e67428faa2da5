// Lines in a plot over time where the run was changed or kicked, in that of a sweep at some values.

import { make } from "./dom.js";
import { hub } from "./hub.js";

export class Marks {
  #places = [];

  // `values`: gives those to mark, else marks are those of the time line.
  constructor(chart, values = () => null) {
    Object.assign(this, { chart, values });
    this.box = make("div", { class: "rodgen-marks", "aria-hidden": "true" });
    chart.plot.over.append(this.box);
  }

  show() {
    const { chart } = this;
    const changes = chart.spec.kind === "time" ? hub.past.marks.map(([t]) => t) : [];
    const [from, to] = chart.shown.x;
    const seen = (this.values() ?? changes).filter((value) => value >= from && value <= to);
    const places = seen.map((value) => Math.round(chart.place(value, 0)[0]));
    if (places.join() === this.#places.join()) return;
    this.#places = places;
    this.box.replaceChildren(...places.map((x) => make("i", { style: `left:${x}px` })));
  }
}
