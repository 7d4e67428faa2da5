// What the channel brings, and when it is drawn: a page has one of it, shared by all components.

import { Past } from "./past.js";
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

// Texts by key, written into every element that has data-text="key".
class Texts {
  #texts = new Map();
  changed = false;

  set(texts) {
    this.changed = true;
    for (const [key, text] of Object.entries(texts)) this.#texts.set(key, String(text));
  }

  // Only what differs is written: elements may come later than their text, or be rendered anew.
  write() {
    this.changed = false;
    for (const element of document.querySelectorAll("[data-text]")) {
      const text = this.#texts.get(element.dataset.text);
      if (text !== undefined && element.textContent !== text) put(element, text);
    }
  }
}

function put(element, text) {
  const only = element.childNodes.length === 1 ? element.firstChild : null;
  // The node is kept where it can be: Vue, which may have made it, goes on with it.
  if (only?.nodeType === Node.TEXT_NODE) only.nodeValue = text;
  else element.textContent = text;
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
    frame: 0,
  };
  texts = new Texts();
  past = new Past((what) => this.send(JSON.stringify(what)));
  // Objects with paint(now, fresh, fully): fresh with a new state, fully where anything else may
  // have changed. They say by true that they want another frame.
  painters = new Set();
  // Called with (id, rows, replace, t) for rows of plots.
  rows = () => {};
  // Called with (id, rows) for rows of the run that is kept.
  ghosts = () => {};
  // Called when the run has begun anew, before what comes of it.
  restarts = new Set();
  // Called with (t, by) for the time that is looked at, null for none, and who has told of it.
  cursors = new Set();
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
    if (header.begun !== this.rod.begun) for (const restart of this.restarts) restart();
    Object.assign(this.rod, { begun: header.begun, repeats: header.repeats, kept: header.kept ?? null });
    if (header.t !== undefined) this.#tell(header.t);
    if (header.line) this.#look(header.line);
    if (header.state !== undefined) this.shown.state = header.state;
    if (header.origin !== undefined) this.rod.origin = header.origin;
    this.#keep(arrays);
    if (header.texts) {
      this.texts.set(header.texts);
      Object.assign(this.shown.texts, header.texts);
    }
    if (header.frame !== undefined) this.#unanswered.push(header.frame);
    this.#wake();
  }

  // The time of the state that is shown, in all places alike.
  #tell(t) {
    this.rod.t = this.shown.t = t;
    this.rod.clock = this.#clock.of(t);
    this.texts.set({ t: this.rod.clock });
  }

  #look(line) {
    const moved = line.past !== this.shown.past;
    this.past.take(line);
    this.shown.past = line.past;
    this.shown.span = [line.from, line.to];
    if (moved) this.cursor(null);
  }

  #keep(arrays) {
    const joints = arrays.find(([name]) => name === "joints")?.[1];
    // A state is whole: a load that it does not have, the rod has no longer.
    if (joints) Object.assign(this.rod, { ...NOTHING, forces: {} });
    for (const [name, array] of arrays) {
      if (name.startsWith("ghost:")) {
        this.ghosts(name.slice(6), array);
      } else if (name.startsWith("plot:") || name.startsWith("plot!")) {
        this.rows(name.slice(5), array, name[4] === "!", this.rod.t);
      } else if (name.startsWith("forces:")) {
        this.rod.forces[name.slice(7)] = array;
      } else if (name === "trail" || name === "trail!") {
        this.rod.trail.add(array, name === "trail!", length(joints));
      } else {
        this.rod[name] = array;
      }
    }
    if (joints) {
      this.rod.frame += 1;
      this.#fresh = true;
      this.shown.pull = [...(this.rod.pull ?? [])];
    }
  }

  // The time `t` is looked at, by one who shows it already; null: none any more, but that of the past.
  cursor(t, by = null) {
    for (const look of this.cursors) look(t ?? this.shown.past, t === null ? null : by);
  }

  // Colours, sizes or options have changed.
  repaint() {
    this.#fully = true;
    this.#wake();
  }

  // Another frame is wanted by a painter, which knows itself what has changed.
  stir() {
    this.#wake();
  }

  // One drawing per animation frame, however often it is asked for. A hidden tab draws nothing
  // and so answers nothing: the server then sends nothing.
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
    if (this.texts.changed) this.texts.write();
    let more = false;
    for (const painter of this.painters) more = painter.paint(now, fresh, fully) || more;
    for (const frame of this.#unanswered.splice(0)) this.send(JSON.stringify({ ack: frame }));
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
    this.texts.write();
  }

  // A new connection begins with a whole state; answers to the old one are of no use to it.
  connected(send) {
    this.send = send ?? (() => {});
    this.#unanswered = [];
    this.past.reconnected();
    this.shown.connected = Boolean(send);
    this.texts.set({ connection: send ? "" : "connection lost: trying again" });
    this.repaint();
  }
}

export const hub = new Hub();
