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

// `changed` asks for a drawing; `emit` sends "kick", "pull", "move", "release".
class Pointer {
  tool = "look"; // or "kick", "pull"
  holds = false;
  #sent = { at: 0, place: [0, 0] }; // of a pull
  #down = new Map(); // pointers that are down: id to [x, y]
  #start = null; // {x, y, hit}
  #moved = false;

  constructor(picture, changed, emit) {
    Object.assign(this, { picture, changed, emit });
    listen(picture.canvas, {
      pointerdown: (event) => this.#press(event),
      pointermove: (event) => this.#move(event),
      pointerup: (event) => this.#release(event),
      pointercancel: (event) => this.#cancel(event),
      pointerleave: () => this.#hover(null),
      wheel: (event) => this.#wheel(event),
      keydown: (event) => this.#key(event),
      dblclick: () => this.#do(() => picture.fit()),
    });
  }

  #do(change) {
    this.picture.settled = true;
    change();
    this.changed();
  }

  // Has another part of the world shown.
  #look(change) {
    this.picture.chosen = true;
    this.#do(change);
  }

  #place(event) {
    return placeOf(event, this.picture.canvas);
  }

  #press(event) {
    if (event.button !== 0) return;
    const [x, y] = this.#place(event);
    this.picture.point(null);
    this.picture.canvas.setPointerCapture(event.pointerId);
    this.#down.set(event.pointerId, [x, y]);
    if (this.#down.size > 1) {
      this.#drop();
      return;
    }
    this.#start = { x, y, hit: this.#hit(x, y) };
    this.#moved = false;
  }

  #move(event) {
    const before = this.#down.get(event.pointerId);
    const now = this.#place(event);
    if (!before) {
      this.#hover(now);
      return;
    }
    if (this.#down.size > 1) this.#pinch(event.pointerId, before, now);
    this.#down.set(event.pointerId, now);
    if (this.#down.size > 1 || !this.#start) return;
    const [dx, dy] = [now[0] - this.#start.x, now[1] - this.#start.y];
    this.#moved ||= Math.hypot(dx, dy) > STILL;
    if (!this.#moved) return;
    const { hit } = this.#start;
    if (hit && this.tool === "pull") this.#pull(hit, now);
    else if (hit) this.#do(() => (this.picture.kick = { ...hit, dx, dy }));
    else this.#look(() => this.picture.camera.pan(now[0] - before[0], now[1] - before[1]));
  }

  // `place`: of the pointer, or null where it has gone.
  #hover(place) {
    this.picture.point(place);
    hub.stir();
    if (!place) return;
    const [x, y] = place;
    this.picture.canvas.style.cursor = this.#hit(x, y) ? "crosshair" : "grab";
  }

  // The link that a kick or a pull from there is for.
  #hit(x, y) {
    const { points, camera, state, options } = this.picture;
    if (this.tool === "pull") {
      const again = caught(x, y, camera, state, points, options.times);
      if (again) return again;
    }
    return this.tool === "look" ? null : met(points, x, y);
  }

  #pull({ link, share }, [x, y]) {
    const begins = !this.picture.hand;
    this.#do(() => (this.picture.hand = { link, share, x, y }));
    const place = this.#held();
    if (begins) {
      this.#sent = { at: performance.now(), place };
      this.emit("pull", { link, share, x: place[0], y: place[1] });
    } else this.follow();
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

  // The pointer lets go: of the far end alone, which stays, or of the rod.
  #free(stays) {
    if (!this.picture.hand) return;
    this.#sent.at = 0;
    if (stays) this.follow();
    this.picture.hand = null;
    if (!stays) this.emit("release", {});
  }

  #pinch(id, before, now) {
    const [other] = [...this.#down].filter(([key]) => key !== id).map(([, place]) => place);
    const size = ([x, y]) => Math.max(Math.hypot(x - other[0], y - other[1]), 1);
    const { camera } = this.picture;
    this.#look(() => {
      camera.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
      camera.zoom(size(now) / size(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    });
  }

  #release(event) {
    if (!this.#down.delete(event.pointerId) || !this.#start) return;
    const [x, y] = this.#place(event);
    const { hit, x: fromX, y: fromY } = this.#start;
    if (hit) {
      const { link, share } = hit;
      const [dx, dy] = this.picture.camera.metres(x - fromX, y - fromY);
      if (this.picture.hand) this.#free(event.shiftKey || this.holds);
      else if (this.#moved && this.tool === "kick") this.emit("kick", { link, share, dx, dy });
    }
    this.#drop();
  }

  #cancel(event) {
    this.#down.delete(event.pointerId);
    this.#drop();
  }

  #drop() {
    this.#free(false);
    this.#start = null;
    this.#do(() => (this.picture.kick = null));
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
    this.#drop();
    if (this.picture.state.pull?.length) this.emit("release", {});
  }
}

export default {
  template: `
    <div class="rodgen-rod">
      <canvas ref="canvas" role="img" tabindex="0" :aria-label="label"></canvas>
    </div>`,
  props: {
    show: Object,
    loads: Array,
    bodies: Array,
    ties: Array,
    bed: Array,
    view: String,
    support: String,
    clampAngle: Number,
    tool: String,
    hold: Boolean,
    perMetre: Number,
    times: Number,
    mode: Object,
    label: String,
    rod: Number,
  },
  mounted() {
    const picture = new Picture(this.$refs.canvas, hub.rod);
    const pointer = new Pointer(
      picture,
      () => hub.repaint(),
      (name, what) => this.$emit(name, what),
    );
    Object.assign(this, { picture, pointer });
    picture.camera.mode = this.view;
    this.set();
    this.painter = {
      paint: (...frame) => {
        const waits = pointer.follow();
        const more = picture.paint(...frame);
        Object.assign(hub.shown, {
          joints: Array.from(picture.points),
          scale: picture.camera.scale,
          mode: picture.options.mode?.text ?? null,
        });
        return more || waits;
      },
    };
    this.sizes = new ResizeObserver(() => {
      picture.resize();
      // At once: a canvas that was resized is blank.
      picture.draw(performance.now());
    });
    this.sizes.observe(this.$el);
    hub.painters.add(this.painter);
  },
  beforeUnmount() {
    this.sizes.disconnect();
    hub.painters.delete(this.painter);
  },
  watch: {
    show: "set",
    bodies: "set",
    ties: "held",
    bed: "held",
    support: "set",
    clampAngle: "set",
    tool: "set",
    hold: "set",
    perMetre: "set",
    times: "held",
    mode: "set",
    view(mode) {
      this.picture.view(mode);
      hub.repaint();
    },
    rod() {
      this.picture.forget();
      hub.repaint();
    },
  },
  methods: {
    set() {
      const { show, loads, bodies, ties, bed, view, support, clampAngle, perMetre, times, mode } = this;
      const marks = { bodies, ties, bed, support, clampAngle };
      const options = { show: { ...show }, loads, ...marks, view, perMetre, times, mode };
      Object.assign(this.picture.options, options);
      Object.assign(this.pointer, { tool: this.tool, holds: this.hold });
      hub.repaint();
    },
    // What is around the rod, or how it is drawn, is other than before.
    held() {
      this.set();
      this.picture.anew();
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
