// How far a rod has come, as it was drawn.

import { about, size } from "./camera.js";

export class Reach {
  #box = null; // [left, bottom, right, top], absolute [m]

  forget() {
    this.#box = null;
  }

  // Joints x0, y0, x1, ... from an origin [m].
  add(joints, [x, y]) {
    const box = size(joints).box.map((end, k) => end + (k % 2 ? y : x));
    this.#box = this.#box ? about(this.#box, box) : box;
  }

  // The box from an origin; null where nothing has been seen.
  from([x, y]) {
    return this.#box?.[0] <= this.#box?.[2] ? this.#box.map((end, k) => end - (k % 2 ? y : x)) : null;
  }
}
