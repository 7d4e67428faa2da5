// Plots in a grid, as many as wanted; drawn one a frame, so that the rod keeps moving.

import { Card } from "rodgen-live/card.js";
import { Glance } from "rodgen-live/glance.js";
import { hub } from "rodgen-live/hub.js";
import { dark } from "rodgen-live/theme.js";

const REST = 1000 / 15; // milliseconds from one drawing of a plot to the next, at least
const SHARE = 5; // times what a drawing costs that a plot rests
const FRAME = 1000 / 60;
const LONGEST = 200; // milliseconds from one frame to the next; beyond, nothing was drawn
const UNSEEN = 1500; // milliseconds between drawings of a plot that is scrolled out of sight
const SLOWEST = 4; // times REST where frames come late

// Which plot is drawn in which frame: at most one, and none too often.
class Queue {
  #last = null; // the card drawn in the frame before
  #before = -Infinity;
  #interval = FRAME; // between frames, of late

  // True while plots wait.
  paint(cards, now) {
    this.#watch(now);
    const waiting = cards.filter((card) => card.dirty);
    const rest = REST * Math.min(Math.max((this.#interval / FRAME) ** 6, 1), SLOWEST);
    const due = waiting.filter((card) => {
      const least = card.seen ? rest : UNSEEN;
      return now - card.drawn >= Math.max(least, SHARE * card.cost);
    });
    const next = due.sort((a, b) => a.drawn - b.drawn)[0];
    next?.draw(now);
    this.#last = next;
    return waiting.length > 0;
  }

  // The browser paints after the script has ended: what that took shows in the next frame. Where
  // frames come late, whatever the cause, plots give way to the rod.
  #watch(now) {
    const passed = now - this.#before;
    this.#before = now;
    if (passed > LONGEST) return;
    this.#interval += 0.03 * (passed - this.#interval);
    if (this.#last && passed > 1.5 * FRAME) this.#last.cost += 0.3 * (passed - FRAME);
  }
}

const EARLY = 64; // messages kept for a plot that the page does not have yet

export default {
  template: `<div class="rodgen-plots"></div>`,
  props: { specs: Array },
  mounted() {
    this.cards = new Map();
    this.early = new Map();
    this.pointed = false; // whether a pointer is at a time of some plot
    this.marks = new Map(); // values that are marked in sweeps, by plot
    this.kept = new Map(); // rows of the run that is kept, by plot
    this.queue = new Queue();
    this.glance = new Glance(hub.past);
    this.shade = dark();
    this.painter = { paint: (...frame) => this.paint(...frame) };
    hub.painters.add(this.painter);
    hub.rows = (...rows) => this.take(...rows);
    hub.ghosts = (id, rows) => this.compare(id, rows);
    hub.restarts.add((this.restart = () => this.each((card) => card.restart())));
    hub.cursors.add((this.look = (t, by) => this.each((card) => card !== by && card.look(t, this.pointed))));
    hub.shown.plots = {};
    this.sort();
    this.fill();
  },
  beforeUnmount() {
    hub.painters.delete(this.painter);
    hub.rows = hub.ghosts = () => {};
    hub.restarts.delete(this.restart);
    hub.cursors.delete(this.look);
    this.each((card) => card.close());
  },
  watch: { specs: { handler: "fill", deep: true } },
  methods: {
    each(does) {
      for (const card of this.cards.values()) does(card);
    },
    // The cards become those of `specs`, in their order.
    fill() {
      const wanted = new Set(this.specs.map((spec) => spec.id));
      for (const id of this.cards.keys()) if (!wanted.has(id)) this.drop(id);
      for (const spec of this.specs) {
        const text = JSON.stringify({ ...spec, wrapped: undefined });
        if (this.cards.get(spec.id)?.text === text) {
          this.cards.get(spec.id).wrap(spec.wrapped);
          continue;
        }
        if (this.cards.has(spec.id)) this.drop(spec.id);
        this.open(spec, text);
      }
      this.order(this.specs.map((spec) => spec.id));
      hub.repaint();
    },
    open(spec, text) {
      const { id } = spec;
      const card = new Card(JSON.parse(JSON.stringify(spec)), {
        remove: () => this.removed(id),
        changed: () => hub.repaint(),
        picked: (row) => this.$emit("picked", { id, row }),
        marks: () => this.marks.get(id),
        looked: (t) => {
          this.pointed = t !== null;
          this.glance.at(t);
          hub.cursor(t, card);
        },
        zoomed: (view) => this.zoomed(card, view),
        wrapped: (wrapped) => this.$emit("wrapped", { id, wrapped }),
      });
      card.text = text;
      this.cards.set(id, card);
      this.$el.append(card.frame);
      card.open();
      for (const rows of this.early.get(id) ?? []) card.take(...rows);
      this.early.delete(id);
      if (this.kept.has(id)) card.compare(this.kept.get(id));
    },
    // Plots over time have one axis; one that is paused has its own.
    zoomed(card, view) {
      const follows = ({ spec, curves }) => spec.kind === "time" && !curves.paused;
      if (follows(card)) this.each((other) => other !== card && follows(other) && other.show(view));
    },
    compare(id, rows) {
      this.kept.set(id, rows);
      this.cards.get(id)?.compare(rows);
    },
    drop(id) {
      this.kept.delete(id);
      this.cards.get(id).close();
      this.cards.delete(id);
      delete hub.shown.plots[id];
    },
    take(id, values, replace) {
      const card = this.cards.get(id);
      if (card) {
        card.take(values, replace);
        return;
      }
      const kept = replace ? [] : (this.early.get(id) ?? []).slice(1 - EARLY);
      this.early.set(id, [...kept, [values, replace]]);
    },
    // Rows of a sweep, of which null is no number.
    sweep(id, rows, marks) {
      this.marks.set(id, marks);
      this.take(id, rows.map((one) => one ?? NaN), true);
      hub.repaint();
    },
    removed(id) {
      const ids = [...this.cards.keys()];
      const next = this.cards.get(ids[ids.indexOf(id) + 1] ?? ids[ids.indexOf(id) - 1]);
      this.drop(id);
      next?.box.focus();
      this.$emit("removed", { id });
    },
    // Appending moves an element: those that stand right are left alone, and so keep the focus.
    order(ids) {
      const focus = document.activeElement;
      ids.forEach((id, k) => {
        const { frame } = this.cards.get(id);
        if (this.$el.children[k] !== frame)
          this.$el.insertBefore(frame, this.$el.children[k] ?? null);
      });
      this.cards = new Map(ids.map((id) => [id, this.cards.get(id)]));
      if (focus && this.$el.contains(focus)) focus.focus();
    },
    move(id, by) {
      const ids = [...this.cards.keys()];
      const from = ids.indexOf(id);
      const to = Math.min(Math.max(from + by, 0), ids.length - 1);
      if (to === from) return;
      ids.splice(to, 0, ...ids.splice(from, 1));
      this.order(ids);
      this.$emit("moved", { ids });
    },
    // A card is dragged by its head onto the place of another.
    sort() {
      let dragged = null;
      const id = (event) => event.target.closest?.("[data-plot]")?.dataset.plot;
      const listen = (name, handler) => this.$el.addEventListener(name, handler);
      listen("dragstart", (event) => {
        dragged = id(event);
        event.dataTransfer.effectAllowed = "move";
      });
      listen("dragover", (event) => dragged && event.preventDefault());
      listen("drop", (event) => {
        const ids = [...this.cards.keys()];
        const by = ids.indexOf(id(event)) - ids.indexOf(dragged);
        if (dragged && id(event)) this.move(dragged, by);
        event.preventDefault();
      });
      listen("dragend", () => (dragged = null));
    },
    paint(now, fresh, fully) {
      if (fully && this.shade !== dark()) {
        this.shade = dark();
        this.each((card) => card.restyle());
      }
      if (fresh || fully) for (const card of this.cards.values()) card.turn(hub.shown.past);
      const more = this.queue.paint([...this.cards.values()], now);
      for (const [id, card] of this.cards) {
        const { curves, draws } = card;
        const { found: at, shown } = card.chart;
        const { x, y, across } = shown;
        const [rows, kept] = [curves.rows.total, curves.ghost.total];
        hub.shown.plots[id] = { rows, kept, draws, x, y, at, seen: across.length };
      }
      return more;
    },
  },
};
