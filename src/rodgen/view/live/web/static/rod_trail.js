// Where the tail and the centre of gravity have been: the last places, in absolute coordinates.

const MOST = 6000;
const PIECES = 4;
const NEAR = 3; // pixels between the places that are drawn
const CLOSE = 1e-3; // of the rod's length: a place nearer to the last one is not kept

export class Trail {
  #places = new Float64Array(4 * MOST);
  #count = 0;

  // Rows of a message, tail x, y and centre of gravity x, y; `anew`: instead of those that are
  // there; `length` of the rod.
  add(rows, anew, length) {
    if (anew) this.#count = 0;
    for (let at = 0; at < rows.length; at += 4) this.#keep(rows, at, CLOSE * length);
  }

  #keep(rows, at, close) {
    const last = 4 * ((this.#count - 1) % MOST);
    const moved = (k) => Math.abs(rows[at + k] - this.#places[last + k]);
    if (this.#count && Math.max(moved(0), moved(1), moved(2), moved(3)) < close) return;
    const next = 4 * (this.#count++ % MOST);
    for (let k = 0; k < 4; k++) this.#places[next + k] = rows[at + k];
  }

  // Up to the present places of `state`.
  draw(context, camera, { origin, joints, point }, colours) {
    if (!this.#count) return;
    context.lineWidth = 1.2;
    context.lineJoin = "bevel";
    const first = Math.max(0, this.#count - MOST);
    const span = (this.#count - 1 - first) / PIECES;
    for (const [column, colour, end] of [
      [2, colours.centre, point ?? [NaN, NaN]],
      [0, colours.tail, joints.slice(-2)],
    ]) {
      context.strokeStyle = colour;
      for (let piece = 0; piece < PIECES; piece++) {
        context.globalAlpha = 0.15 + (0.6 * (piece + 1)) / PIECES;
        context.beginPath();
        const ends = [piece, piece + 1].map((k) => first + Math.floor(k * span));
        this.#piece(context, camera, origin, column, ...ends);
        if (piece === PIECES - 1) context.lineTo(...camera.screen(end[0], end[1]));
        context.stroke();
      }
    }
    context.globalAlpha = 1;
  }

  // Places that lie closer are passed over.
  #piece(context, camera, origin, column, from, to) {
    let [px, py] = [Infinity, Infinity];
    for (let k = from; k <= to; k++) {
      const at = 4 * (k % MOST) + column;
      const [x, y] = camera.screen(this.#places[at] - origin[0], this.#places[at + 1] - origin[1]);
      if (k !== from && k !== to && Math.abs(x - px) + Math.abs(y - py) < NEAR) continue;
      if (k === from) context.moveTo(x, y);
      else context.lineTo(x, y);
      [px, py] = [x, y];
    }
  }
}
