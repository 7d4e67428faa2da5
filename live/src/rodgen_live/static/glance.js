// The rod as it was at the time of a plot at which the pointer rests.

const REST = 150; // milliseconds; a pointer on its way over the page leaves the rod alone

export class Glance {
  #past;
  #t = null; // where the pointer is [s]
  #before; // where the page looked until then, null for the present; none while it does not glance
  #waiting = null;

  constructor(past) {
    this.#past = past;
  }

  // The pointer is over a time [s] of a plot; null: it is no more.
  at(t) {
    if (t === this.#t) return;
    this.#t = t;
    if (t === null) this.#end();
    else if (this.#before !== undefined) this.#past.look(t);
    else this.#waiting ??= setTimeout(() => this.#begin(), REST);
  }

  #begin() {
    this.#before = this.#past.back ? this.#past.place : null;
    this.#past.look(this.#t);
  }

  #end() {
    clearTimeout(this.#waiting);
    this.#waiting = null;
    if (this.#before !== undefined) this.#past.look(this.#before);
    this.#before = undefined;
  }
}
