// Plots in a grid, as many as wanted; drawn one a frame, so that the rod keeps moving.

import { Card } from "rodgen-live/card.js";
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
const GLANCE = 150; // milliseconds; a pointer on its way over the page leaves the rod alone
const MANY_CURVES = ["time", "sweep"]; // kinds of plots; others have a curve of y over x

const idOf = (element) => element.closest?.("[data-plot]")?.dataset.plot;

export default {
  // A card is dragged by its head onto the place of another.
  template: `<div class="rodgen-plots" @dragstart="drag" @dragover.prevent @drop.prevent="drop"></div>`,
  props: { specs: Array },
  mounted() {
    this.cards = new Map();
    this.early = new Map(); // what is to be done by cards that are not there yet, by plot
    this.pointed = null; // the time of some plot that a pointer is at [s]
    this.queue = new Queue();
    this.shade = dark();
    hub.painters.add(this);
    hub.plots = this;
    hub.shown.plots = {};
    this.fill();
  },
  beforeUnmount() {
    hub.painters.delete(this);
    hub.plots = null;
    this.each((card) => card.close());
  },
  watch: { specs: { handler: "fill", deep: true } },
  methods: {
    each(does) {
      for (const card of this.cards.values()) does(card);
    },
    // The cards become those of `specs`, in their order.
    fill() {
      const ids = this.specs.map(({ id }) => id);
      for (const id of this.cards.keys()) if (!ids.includes(id)) this.close(id);
      for (const spec of this.specs) {
        const text = JSON.stringify({ ...spec, wrapped: undefined });
        const card = this.cards.get(spec.id);
        if (card?.text === text) card.wrap(spec.wrapped);
        else this.open(spec, text);
      }
      this.order(ids);
      hub.repaint();
    },
    open({ id, wrapped }, text) {
      if (this.cards.has(id)) this.close(id);
      const spec = { ...JSON.parse(text), wrapped };
      if (!MANY_CURVES.includes(spec.kind)) {
        const { label, unit } = spec.y;
        spec.series = [{ ...spec.series[0], name: label, label, unit }];
      }
      const card = new Card(spec, this);
      card.text = text;
      this.cards.set(id, card);
      this.$el.append(card.frame);
      card.open();
      for (const does of this.early.get(id) ?? []) does(card);
      this.early.delete(id);
    },
    // The pointer is over a time [s] of a card, null: over none. Where it rests, the rod is shown
    // as it was then.
    point(t, by) {
      const before = this.pointed;
      this.pointed = t;
      this.look(t ?? hub.shown.past, t === null ? null : by);
      if (t === before) return;
      if (t === null) {
        clearTimeout(this.waiting);
        this.waiting = null;
        if (this.before !== undefined) hub.past.look(this.before);
        this.before = undefined;
      } else if (this.before !== undefined) hub.past.look(t);
      else this.waiting ??= setTimeout(() => this.glance(), GLANCE);
    },
    glance() {
      this.before = hub.past.at;
      hub.past.look(this.pointed);
    },
    restart() {
      this.each((card) => card.restart());
    },
    // The time `t` is looked at, null: none is, but for a card that has told of it.
    look(t, by = null) {
      this.each((card) => card !== by && card.look(t));
    },
    // Shows a part of a card. Plots over time have one axis; one that is paused has its own.
    zoom(card, view) {
      const follows = ({ spec, curves }) => spec.kind === "time" && !curves.paused;
      const along = (other) => other === card || (follows(card) && follows(other));
      this.each((other) => along(other) && other.show(view));
    },
    // Has something done by a card, once the page has it.
    tell(id, does) {
      const card = this.cards.get(id);
      if (card) does(card);
      else this.early.set(id, [...(this.early.get(id) ?? []), does].slice(-EARLY));
    },
    compare(id, rows) {
      this.tell(id, (card) => card.compare(rows));
    },
    close(id) {
      this.cards.get(id).close();
      this.cards.delete(id);
      delete hub.shown.plots[id];
    },
    take(id, values, replace) {
      this.tell(id, (card) => card.take(values, replace));
    },
    // Rows of a sweep, of which null is no number.
    sweep(id, rows, marks) {
      this.tell(id, (card) => {
        card.swept = marks;
        card.take(rows.map((one) => one ?? NaN), true);
      });
      hub.repaint();
    },
    remove(id) {
      const ids = [...this.cards.keys()];
      const next = this.cards.get(ids[ids.indexOf(id) + 1] ?? ids[ids.indexOf(id) - 1]);
      this.close(id);
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
    drag({ target, dataTransfer }) {
      dataTransfer.setData("text/plain", idOf(target));
      dataTransfer.effectAllowed = "move";
    },
    drop({ target, dataTransfer }) {
      const ids = [...this.cards.keys()];
      const from = ids.indexOf(dataTransfer.getData("text/plain"));
      const to = ids.indexOf(idOf(target));
      if (from < 0 || to < 0 || from === to) return;
      ids.splice(to, 0, ...ids.splice(from, 1));
      this.order(ids);
      this.$emit("moved", { ids });
    },
    paint(now, fresh, fully) {
      if (fully && this.shade !== dark()) {
        this.shade = dark();
        this.each((card) => card.restyle());
      }
      if (fresh || fully) this.each((card) => card.turn(hub.shown.past));
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
