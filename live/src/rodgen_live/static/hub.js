// What the channel brings, and when it is drawn: a page has one of it, shared by all components.

import { length, Trail } from "./rod_links.js";
import { Written } from "./scales.js";

const TEXT = new TextDecoder();
const SECOND = 1000;

// A message of the server (message.py): a JSON header, then arrays, each padded to 8 bytes.
// {header, arrays: [[name, typed array], ...]}; the arrays are views of the buffer.
function decode(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(TEXT.decode(new Uint8Array(buffer, 4, size)));
  const arrays = [];
  let at = 4 + size;
  for (const [name, type, count] of header.arrays ?? []) {
    const kind = type === "f8" ? Float64Array : Float32Array;
    const array = new kind(buffer, at, count);
    arrays.push([name, array]);
    at += 8 * Math.ceil(array.byteLength / 8);
  }
  return { header, arrays };
}

// What can be looked back at: from when to when, what was done to the run meanwhile, and where the
// page looks. Places are asked for by `send`, the next one when the last has been answered.
class Past {
  from = 0; // of the first and the last sample that is kept [s]
  to = 0;
  at = null; // where the page looks, or will as soon as it can [s]; null: the present
  marks = []; // [[t, what was done], ...]
  keeps = false; // whether a run is kept, to compare with, when another begins
  #wanted = false; // whether `at` is still to be asked for
  #asked = false;

  constructor(send) {
    this.send = send;
  }

  get place() {
    return this.at ?? this.to;
  }

  get back() {
    return this.at !== null;
  }

  take({ from, to, past, keeps, marks }) {
    Object.assign(this, { from, to, keeps, marks: marks ?? this.marks });
    if (!this.#wanted) this.at = past;
    this.ready();
  }

  // Shows the sample nearest to t [s]; null: the present.
  look(t) {
    this.at = t;
    this.#wanted = true;
    this.#ask();
  }

  // Has something else done, from the sample that is shown by then.
  tell(what) {
    this.#wanted = false;
    this.send(what);
  }

  // The last place has been answered; a new connection has not been asked for any.
  ready() {
    this.#asked = false;
    this.#ask();
  }

  #ask() {
    if (this.#asked || !this.#wanted) return;
    this.#wanted = false;
    this.#asked = true;
    this.send({ look: this.at }); // which may be answered at once
  }
}

// What a state may have beside its joints; ghost: joints of the run that is kept.
const NOTHING = { omega: null, moment: null, section: null, point: null, ghost: null, pull: null };

class Hub {
  rod = {
    t: null,
    clock: "", // that time, as it is written
    begun: null, // how many runs have begun
    kept: null, // from when to when there is a run to compare with [s]
    repeats: false, // whether the last is like the one before
    origin: [0, 0],
    joints: null,
    ...NOTHING,
    forces: {},
    trail: new Trail(),
  };
  past = new Past((what) => this.send(what));
  // Objects with paint(now, fresh, fully): fresh with a new state, fully where anything else may
  // have changed. They say by true that they want another frame.
  painters = new Set();
  // The plots of the page: take(id, rows, replace); compare(id, rows) of the run that is kept;
  // restart() before what comes of another run; look(t): the time that is looked at, null for none.
  plots = null;
  send = () => {};
  // What the page tells of itself as window.rodgenLive, for tests and benchmarks to wait for:
  //   connected, state: whether there is a connection, and the state of the run;
  //   frames, fps, milliseconds: how often a new state was drawn, in all and in the last second, and
  //     how long scripts take for that;
  //   t, past, span: the time that is shown, that of the past which is looked at (null: the present),
  //     and those of the first and the last sample that are kept [s];
  //   joints, scale, pull, mode: of the rod that is drawn, places of its joints in the picture, x and
  //     y in turn [pixels], pixels per metre, its pull as message.py has it, and its mode in words;
  //   texts: the panel of values, by key, as it was told last;
  //   plots: by id, rows that came, kept (of the run that is kept), draws, and of what is drawn the
  //     ends of its axes x and y, the row at that is looked at, and how many are seen.
  shown = {
    ...{ connected: false, state: null, frames: 0, fps: 0, milliseconds: 0 },
    ...{ t: null, past: null, span: null, joints: [], scale: null, pull: [], mode: null },
    ...{ texts: {}, plots: {} },
  };
  #texts = new Map(); // by key, of every element that has data-text="key"
  #written = true; // whether they stand in the page
  #clock = new Written();
  #unanswered = [];
  #drawn = [];
  #fresh = false;
  #fully = false;
  #waiting = false;

  constructor() {
    window.rodgenLive = this.shown;
    new MutationObserver(() => this.repaint()).observe(document.body, {
      attributeFilter: ["class"],
    });
    setInterval(() => this.#count(performance.now()), SECOND / 2);
  }

  receive(buffer) {
    const { header, arrays } = decode(buffer);
    const { rod, shown } = this;
    if (header.begun !== rod.begun) this.plots?.restart();
    const { begun, repeats, kept = null, state, t = rod.t, origin = rod.origin, line } = header;
    Object.assign(rod, { begun, repeats, kept, origin });
    if (t !== rod.t) Object.assign(rod, { t, clock: this.#clock.of(t) });
    this.#keep(arrays);
    const moved = line.past !== shown.past;
    Object.assign(shown, { t, state, past: line.past, span: [line.from, line.to] });
    if (moved) this.plots?.look(line.past);
    Object.assign(shown.texts, header.texts);
    this.#write({ t: rod.clock, ...header.texts });
    if (header.frame !== undefined) this.#unanswered.push(header.frame);
    this.past.take(line);
    this.#wake();
  }

  #keep(arrays) {
    const joints = arrays.find(([name]) => name === "joints")?.[1];
    // A state is whole: a load that it does not have, the rod has no longer.
    if (joints) Object.assign(this.rod, { ...NOTHING, forces: {} });
    for (const [name, array] of arrays) {
      const [kind, id] = name.split(/[:!](.*)/);
      const anew = name[kind.length] === "!";
      if (kind === "ghost" && id) this.plots?.compare(id, array);
      else if (kind === "plot") this.plots?.take(id, array, anew);
      else if (kind === "forces") this.rod.forces[id] = array;
      else if (kind === "trail") this.rod.trail.add(array, anew, length(joints));
      else this.rod[name] = array;
    }
    if (!joints) return;
    this.#fresh = true;
    this.shown.pull = [...(this.rod.pull ?? [])];
  }

  #write(texts) {
    for (const [key, text] of Object.entries(texts)) this.#texts.set(key, String(text));
    this.#written = false;
  }

  // Only what differs is written: elements may come later than their text, or be rendered anew.
  #show() {
    this.#written = true;
    for (const element of document.querySelectorAll("[data-text]")) {
      const text = this.#texts.get(element.dataset.text);
      if (text !== undefined && element.textContent !== text) element.textContent = text;
    }
  }

  // Colours, sizes or options have changed.
  repaint() {
    this.#fully = true;
    this.#wake();
  }

  // Another frame is wanted: one drawing per animation frame, however often it is asked for. A
  // hidden tab draws nothing and so answers nothing: the server then sends nothing.
  #wake() {
    if (this.#waiting) return;
    this.#waiting = true;
    requestAnimationFrame((now) => this.#paint(now));
  }

  #paint(now) {
    this.#waiting = false;
    const begin = performance.now();
    const [fresh, fully] = [this.#fresh, this.#fully];
    this.#fresh = this.#fully = false;
    let more = false;
    for (const painter of this.painters) more = painter.paint(now, fresh, fully) || more;
    // Last: painters ask for sizes, which the browser would compute anew after each change.
    if (!this.#written) this.#show();
    for (const frame of this.#unanswered.splice(0)) this.send({ ack: frame });
    if (fresh) {
      this.shown.frames += 1;
      this.#drawn.push(now);
    }
    const spent = performance.now() - begin;
    this.shown.milliseconds += 0.05 * (spent - this.shown.milliseconds);
    if (more) this.#wake();
  }

  // Frames with a new state of the rod drawn in the last second.
  #count(now) {
    while (this.#drawn.length && this.#drawn[0] < now - SECOND) this.#drawn.shift();
    this.shown.fps = this.#drawn.length;
    this.#show();
  }

  // A new connection begins with a whole state; answers to the old one are of no use to it.
  connected(send) {
    this.send = send ?? (() => {});
    this.#unanswered = [];
    this.past.ready();
    this.shown.connected = Boolean(send);
    this.#write({ connection: send ? "" : "connection lost: trying again" });
    this.repaint();
  }
}

export const hub = new Hub();
