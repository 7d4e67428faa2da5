// Which plot is drawn in which frame: at most one, and none too often.

const REST = 1000 / 15; // milliseconds from one drawing of a plot to the next, at least
const SHARE = 5; // times what a drawing costs that a plot rests
const FRAME = 1000 / 60;
const LONGEST = 200; // milliseconds from one frame to the next; beyond, nothing was drawn
const UNSEEN = 1500; // milliseconds between drawings of a plot that is scrolled out of sight
const SLOWEST = 4; // times REST where frames come late

export class Queue {
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
