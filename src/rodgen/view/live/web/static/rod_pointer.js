// Pointer, wheel and keys over the picture of the rod.

const NEAR = 12; // pixels from a link that still meet it
const STILL = 4; // pixels that a click may move

// The link nearest to (px, py): {link, share, distance}, in pixels; points as x0, y0, ...
export function nearest(points, px, py) {
  let best = { distance: Infinity };
  for (let at = 0; at + 3 < points.length; at += 2) {
    const [x, y] = [points[at], points[at + 1]];
    const [dx, dy] = [points[at + 2] - x, points[at + 3] - y];
    const square = dx * dx + dy * dy;
    const along = square > 0 ? ((px - x) * dx + (py - y) * dy) / square : 0;
    const share = Math.min(Math.max(along, 0), 1);
    const distance = Math.hypot(x + share * dx - px, y + share * dy - py);
    if (distance < best.distance) {
      best = { link: at / 2, share, distance };
    }
  }
  return best;
}

// `changed` asks for a drawing; `emit` sends "link" and "kick".
export class Pointer {
  kicks = false;
  #down = new Map(); // pointers that are down: id to [x, y]
  #start = null; // {x, y, hit}
  #moved = false;

  constructor(picture, changed, emit) {
    Object.assign(this, { picture, changed, emit });
    const canvas = picture.canvas;
    const listen = (name, handler) =>
      canvas.addEventListener(name, handler.bind(this), { passive: false });
    listen("pointerdown", this.#press);
    listen("pointermove", this.#move);
    listen("pointerup", this.#release);
    listen("pointercancel", this.#cancel);
    listen("wheel", this.#wheel);
    listen("keydown", this.#key);
    listen("dblclick", () => this.#do(() => picture.fit()));
  }

  #do(change) {
    this.picture.settled = true;
    change();
    this.changed();
  }

  #place(event) {
    const box = this.picture.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  #press(event) {
    if (event.button !== 0) return;
    const [x, y] = this.#place(event);
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
    else this.#do(() => this.picture.camera.pan(now[0] - before[0], now[1] - before[1]));
  }

  #hover([x, y]) {
    this.picture.canvas.style.cursor = this.#hit(x, y) ? "crosshair" : "grab";
  }

  // The link that a kick from there is for.
  #hit(x, y) {
    const hit = this.kicks ? nearest(this.picture.points, x, y) : null;
    return hit?.distance <= NEAR ? hit : null;
  }

  #pinch(id, before, now) {
    const [other] = [...this.#down].filter(([key]) => key !== id).map(([, place]) => place);
    const size = ([x, y]) => Math.max(Math.hypot(x - other[0], y - other[1]), 1);
    const { camera } = this.picture;
    this.#do(() => {
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
    const pixels = event.deltaY * (event.deltaMode === 1 ? 33 : 1);
    this.#do(() => this.picture.camera.zoom(Math.exp(-0.0015 * pixels), ...this.#place(event)));
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { camera } = this.picture;
    const keys = {
      "+": () => camera.zoom(1.25),
      "=": () => camera.zoom(1.25),
      "-": () => camera.zoom(0.8),
      0: () => this.picture.fit(),
      ArrowLeft: () => camera.pan(40, 0),
      ArrowRight: () => camera.pan(-40, 0),
      ArrowUp: () => camera.pan(0, 40),
      ArrowDown: () => camera.pan(0, -40),
      Escape: () => this.#drop(),
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    this.#do(keys[event.key]);
  }
}
