// Where the tail and the centre of gravity have been: the last places, in absolute coordinates.

const MOST = 1500;
const PIECES = 4;
const NEAR = 3; // pixels between the places that are drawn

export class Trail {
  #places = new Float64Array(4 * MOST);
  #count = 0;
  #time = null;

  clear() {
    this.#count = 0;
  }

  // A run that begins anew goes back in time: so does its trail.
  add(t, origin, joints, point) {
    if (t !== null && this.#time !== null && t < this.#time) this.clear();
    if (t !== null && t === this.#time) return;
    this.#time = t;
    const at = 4 * (this.#count++ % MOST);
    const last = joints.length - 2;
    this.#places[at] = origin[0] + joints[last];
    this.#places[at + 1] = origin[1] + joints[last + 1];
    this.#places[at + 2] = origin[0] + (point?.[0] ?? NaN);
    this.#places[at + 3] = origin[1] + (point?.[1] ?? NaN);
  }

  draw(context, camera, origin, colours) {
    context.lineWidth = 1.2;
    context.lineJoin = "bevel";
    const first = Math.max(0, this.#count - MOST);
    for (const [column, colour] of [
      [2, colours.centre],
      [0, colours.tail],
    ]) {
      context.strokeStyle = colour;
      for (let piece = 0; piece < PIECES; piece++) {
        const span = (this.#count - 1 - first) / PIECES;
        context.globalAlpha = 0.15 + (0.6 * (piece + 1)) / PIECES;
        const ends = [first + Math.floor(piece * span), first + Math.floor((piece + 1) * span)];
        this.#piece(context, camera, origin, column, ...ends);
      }
    }
    context.globalAlpha = 1;
  }

  // Places that lie closer are passed over.
  #piece(context, camera, origin, column, from, to) {
    let [px, py] = [Infinity, Infinity];
    context.beginPath();
    for (let k = from; k <= to; k++) {
      const at = 4 * (k % MOST) + column;
      const [x, y] = camera.screen(this.#places[at] - origin[0], this.#places[at + 1] - origin[1]);
      if (k !== from && k !== to && Math.abs(x - px) + Math.abs(y - py) < NEAR) continue;
      if (k === from) context.moveTo(x, y);
      else context.lineTo(x, y);
      [px, py] = [x, y];
    }
    context.stroke();
  }
}
