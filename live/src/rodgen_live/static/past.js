// What can be looked back at: from when to when, what was done to the run meanwhile, and where the
// page looks. Places are asked for by `send`, the next one when the last has been answered.

export class Past {
  from = 0; // of the first and the last sample that is kept [s]
  to = 0;
  count = 0; // of samples
  at = null; // the sample that is shown [s]; null: the present
  marks = []; // [[t, what was done], ...]
  keeps = false; // whether a run is kept, to compare with, when another begins
  #wanted; // asked for next; null: the present
  #asked = false;

  constructor(send) {
    this.send = send;
  }

  // Where the page looks, or will as soon as it can [s].
  get place() {
    return (this.#wanted === undefined ? this.at : this.#wanted) ?? this.to;
  }

  get back() {
    return (this.#wanted === undefined ? this.at : this.#wanted) !== null;
  }

  // How far along a time is, from 0 to 1.
  share(t) {
    const span = this.to - this.from;
    return span > 0 ? Math.min(Math.max((t - this.from) / span, 0), 1) : 1;
  }

  take({ from, to, count, past, keeps, marks }) {
    Object.assign(this, { from, to, count, at: past, keeps, marks: marks ?? this.marks });
    this.#asked = false;
    this.#ask();
  }

  // Shows the sample nearest to t [s]; null: the present.
  look(t) {
    this.#wanted = t;
    this.#ask();
  }

  // Shows a sample so many further on.
  step(by) {
    this.#wanted = undefined;
    this.send({ step: by });
  }

  keep(keeps) {
    this.send({ keep: keeps });
  }

  // Begins another run from the sample that is shown.
  branch() {
    this.#wanted = undefined;
    this.send({ branch: null });
  }

  // A new connection has not been asked for anything.
  reconnected() {
    this.#asked = false;
  }

  #ask() {
    if (this.#asked || this.#wanted === undefined) return;
    this.at = this.#wanted;
    this.#wanted = undefined;
    this.#asked = true;
    this.send({ look: this.at }); // which may be answered at once
  }
}
