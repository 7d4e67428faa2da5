// The rod, drawn live: a canvas that shows the newest state of the channel, and what pointer, wheel
// and keys do over it.

import { act, listen, placeOf, save, turned } from "rodgen-live/dom.js";
import { hub } from "rodgen-live/hub.js";
import { Picture } from "rodgen-live/picture.js";
import { met } from "rodgen-live/rod_hint.js";

const STILL = 4; // pixels that a click may move

// `changed` asks for a drawing; `emit` sends "link" and "kick".
class Pointer {
  kicks = false;
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
    if (hit) this.#do(() => (this.picture.kick = { ...hit, dx, dy }));
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

  // The link that a kick from there is for.
  #hit(x, y) {
    return this.kicks ? met(this.picture.points, x, y) : null;
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
      if (this.#moved) this.emit("kick", { link, share, dx, dy });
      else this.emit("link", { link, share });
    }
    this.#drop();
  }

  #cancel(event) {
    this.#down.delete(event.pointerId);
    this.#drop();
  }

  #drop() {
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
    act(event, { Escape: () => this.#drop() });
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
    kick: Boolean,
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
        const more = picture.paint(...frame);
        hub.shown.scale = picture.camera.scale;
        return more;
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
    kick: "set",
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
      this.pointer.kicks = this.kick;
      hub.repaint();
    },
    // What is around the rod, or how it is drawn, is other than before.
    held() {
      this.set();
      this.picture.refit();
    },
    fit() {
      this.picture.fit();
      hub.repaint();
    },
    reset_scale() {
      this.picture.resetScale();
      hub.repaint();
    },
    png(name) {
      this.$refs.canvas.toBlob((blob) => save(blob, name || "rod.png"));
    },
  },
};
