// A drawing that is kept, and made anew only where what it depends on has changed.

export class Layer {
  #canvas = document.createElement("canvas");
  #key = null;

  // Puts a drawing of width times height pixels at (x, y). `paint` makes it, from its own corner
  // (0, 0); `key` is a text of all that it depends on.
  put(context, dense, [x, y, width, height], key, paint) {
    const full = `${key}/${width}/${height}/${dense}`;
    if (this.#key !== full) {
      this.#key = full;
      Object.assign(this.#canvas, {
        width: Math.ceil(width * dense),
        height: Math.ceil(height * dense),
      });
      const own = this.#canvas.getContext("2d");
      own.scale(dense, dense);
      own.font = context.font;
      paint(own);
    }
    context.drawImage(this.#canvas, x, y, this.#canvas.width / dense, this.#canvas.height / dense);
  }
}
