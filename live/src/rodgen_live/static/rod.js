// The rod, drawn live: a canvas that shows the newest state of the channel, and what pointer, wheel
// and keys do over it.

import { act, listen, placeOf, save, turned } from "rodgen-live/dom.js";
import { hub } from "rodgen-live/hub.js";
import { Picture } from "rodgen-live/picture.js";
import { met } from "rodgen-live/rod_hint.js";
import { caught, held } from "rodgen-live/rod_pull.js";

const STILL = 4; // pixels that a click may move
const APART = 30; // ms between two places of a pull that are sent
const SAME = 0.25; // pixels by which they differ at least

// `emit` sends "kick", "pull", "move", "release".
class Pointer {
  #sent = { at: 0, place: [0, 0] }; // of a pull
  #down = new Map(); // pointers that are down: id to [x, y]
  #start = null; // where one of them began to drag: {x, y, hit}

  constructor(picture, emit) {
    Object.assign(this, { picture, emit });
    listen(picture.canvas, {
      pointerdown: (event) => this.#press(event),
      pointermove: (event) => this.#move(event),
      pointerup: (event) => this.#release(event),
      pointercancel: (event) => this.#drop(event),
      pointerleave: () => this.#hover(null),
      wheel: (event) => this.#wheel(event),
      keydown: (event) => this.#key(event),
      dblclick: () => this.#look(() => picture.fit()),
    });
  }

  // Has another part of the world shown.
  #look(change) {
    this.picture.chosen = true;
    change();
    hub.repaint();
  }

  #place(event) {
    return placeOf(event, this.picture.canvas);
  }

  #press(event) {
    if (event.button !== 0) return;
    const [x, y] = this.#place(event);
    this.picture.pointed = null;
    this.picture.canvas.setPointerCapture(event.pointerId);
    if (this.#down.size) this.#drop(event);
    else this.#start = { x, y, hit: this.#hit(x, y) };
    this.#down.set(event.pointerId, [x, y]);
  }

  #move(event) {
    const { picture } = this;
    const before = this.#down.get(event.pointerId);
    const now = this.#place(event);
    if (!before) {
      this.#hover(now);
      return;
    }
    this.#down.set(event.pointerId, now);
    if (this.#down.size > 1) this.#pinch(event.pointerId, before, now);
    if (!this.#start) return;
    const { x, y, hit } = this.#start;
    const [dx, dy] = [now[0] - x, now[1] - y];
    this.#start.moved ||= Math.hypot(dx, dy) > STILL;
    if (!this.#start.moved) return;
    if (!hit) this.#look(() => picture.camera.pan(now[0] - before[0], now[1] - before[1]));
    else if (picture.options.tool === "pull") this.#pull(hit, now);
    else picture.kick = { ...hit, dx, dy };
    hub.repaint();
  }

  // `place`: of the pointer, or null where it has gone.
  #hover(place) {
    this.picture.pointed = place;
    hub.repaint();
    if (place) this.picture.canvas.style.cursor = this.#hit(...place) ? "crosshair" : "grab";
  }

  // The link that a kick or a pull from there is for.
  #hit(x, y) {
    const { points, camera, state, options } = this.picture;
    if (options.tool === "look") return null;
    const again = options.tool === "pull" && caught(x, y, camera, state, points, options.times);
    return again || met(points, x, y);
  }

  #pull({ link, share }, [x, y]) {
    const begins = !this.picture.hand;
    this.picture.hand = { link, share, x, y };
    if (!begins) {
      this.follow();
      return;
    }
    const place = this.#held();
    this.#sent = { at: performance.now(), place };
    this.emit("pull", { link, share, x: place[0], y: place[1] });
  }

  // The world's place of the pointer that pulls [m].
  #held() {
    const { hand, camera, state, points, options } = this.picture;
    return held(hand, camera, state, points, options.times);
  }

  // Has the far end of a pull go where the pointer is by now: the view may move below it, too.
  // Returns whether that has to wait.
  follow(now = performance.now()) {
    if (!this.picture.hand) return false;
    const place = this.#held();
    const moved = place.map((part, k) => part - this.#sent.place[k]);
    if (Math.hypot(...moved) * this.picture.camera.scale < SAME) return false;
    if (now - this.#sent.at < APART) return true;
    this.#sent = { at: now, place };
    this.emit("move", { x: place[0], y: place[1] });
    return false;
  }

  #pinch(id, before, now) {
    const [, other] = [...this.#down].find(([key]) => key !== id);
    const size = ([x, y]) => Math.max(Math.hypot(x - other[0], y - other[1]), 1);
    const { camera } = this.picture;
    this.#look(() => {
      camera.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
      camera.zoom(size(now) / size(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    });
  }

  #release(event) {
    const { kick, hand, camera, options } = this.picture;
    if (kick) {
      const [dx, dy] = camera.metres(kick.dx, kick.dy);
      this.emit("kick", { link: kick.link, share: kick.share, dx, dy });
    } else if (hand && (event.shiftKey || options.hold)) {
      this.follow(Infinity);
      this.picture.hand = null; // the far end stays
    }
    this.#drop(event);
  }

  // The pointer is up, or one of several: it lets go of the rod.
  #drop({ pointerId }) {
    this.#down.delete(pointerId);
    if (this.picture.hand) this.emit("release", {});
    this.picture.hand = this.picture.kick = this.#start = null;
    hub.repaint();
  }

  #wheel(event) {
    event.preventDefault();
    const factor = Math.exp(-0.0015 * turned(event));
    this.#look(() => this.picture.camera.zoom(factor, ...this.#place(event)));
  }

  #key(event) {
    const { camera } = this.picture;
    const moves = {
      "+": () => camera.zoom(1.25),
      "=": () => camera.zoom(1.25),
      "-": () => camera.zoom(0.8),
      0: () => this.picture.fit(),
      ArrowLeft: () => camera.pan(40, 0),
      ArrowRight: () => camera.pan(-40, 0),
      ArrowUp: () => camera.pan(0, 40),
      ArrowDown: () => camera.pan(0, -40),
    };
    act(event, moves, (move) => this.#look(move));
    act(event, { Escape: () => this.#escape() });
  }

  // Lets go of a kick, and of a pull that stays.
  #escape() {
    this.#drop({});
    if (this.picture.state.pull?.length) this.emit("release", {});
  }
}

export default {
  template: `
    <div class="rodgen-rod">
      <canvas ref="canvas" role="img" tabindex="0" :aria-label="label"></canvas>
      <div ref="hint" class="rodgen-hint" hidden></div>
    </div>`,
  props: {
    ...{ show: Object, loads: Array, bodies: Array, ties: Array, bed: Array, mode: Object },
    ...{ obstacles: Array },
    ...{ view: String, support: String, tool: String, label: String, hold: Boolean },
    ...{ restShape: Array, perMetre: Number, times: Number, rod: Number },
  },
  mounted() {
    const { canvas, hint } = this.$refs;
    const options = () => ({ ...this.$props });
    const picture = new Picture(canvas, hint, hub.rod, options());
    this.picture = picture;
    this.pointer = new Pointer(picture, (name, what) => this.$emit(name, what));
    this.$watch(options, (now, before) => {
      const other = (...names) => names.some((name) => now[name] !== before[name]);
      picture.options = now;
      // What is around the rod, or how it is drawn, is other than before.
      if (other("ties", "bed", "obstacles", "times")) picture.anew();
      if (other("view")) picture.fit();
      if (other("rod")) picture.forget();
      hub.repaint();
    });
    this.sizes = new ResizeObserver(() => {
      picture.resize();
      // At once: a canvas that was resized is blank.
      picture.draw(performance.now());
    });
    this.sizes.observe(this.$el);
    hub.painters.add(this);
  },
  beforeUnmount() {
    this.sizes.disconnect();
    hub.painters.delete(this);
  },
  methods: {
    paint(...frame) {
      const { picture } = this;
      const waits = this.pointer.follow();
      const more = picture.paint(...frame);
      const { points, camera, options } = picture;
      const mode = options.mode?.text ?? null;
      Object.assign(hub.shown, { joints: Array.from(points), scale: camera.scale, mode });
      return more || waits;
    },
    fit() {
      this.picture.fit();
      hub.repaint();
    },
    png(name) {
      this.$refs.canvas.toBlob((blob) => save(blob, name || "rod.png"));
    },
  },
};
