// Rows of a plot: a ring of doubles, bounded.

export const MOST = 20000;
const FIRST = 512;

export class Rows {
  total = 0; // rows since it was cleared; the last `length` of them are kept

  constructor(columns) {
    this.columns = columns;
    this.clear();
  }

  get length() {
    return Math.min(this.total, this.capacity);
  }

  get first() {
    return this.total - this.length;
  }

  clear() {
    this.total = 0;
    this.capacity = FIRST;
    this.data = new Float64Array(FIRST * this.columns);
  }

  // Rows one after the other; what does not make a whole row is left out.
  append(values) {
    const rows = Math.floor(values.length / this.columns);
    this.#grow(this.length + rows);
    for (let k = Math.max(0, rows - this.capacity); k < rows; k++) {
      const at = ((this.total + k) % this.capacity) * this.columns;
      this.data.set(values.subarray(k * this.columns, (k + 1) * this.columns), at);
    }
    this.total += rows;
  }

  #grow(wanted) {
    if (wanted <= this.capacity || this.capacity >= MOST) return;
    const capacity = Math.min(Math.max(2 * this.capacity, wanted), MOST);
    const data = new Float64Array(capacity * this.columns);
    for (let row = this.first; row < this.total; row++) {
      const from = (row % this.capacity) * this.columns;
      data.set(this.data.subarray(from, from + this.columns), (row % capacity) * this.columns);
    }
    Object.assign(this, { capacity, data });
  }

  // By the number that the row had when it came.
  at(row, column) {
    return this.data[(row % this.capacity) * this.columns + column];
  }

  // The first of the rows from..to (exclusive) with x at or above `value`; x ascends.
  search(value, from, to) {
    let [low, high] = [from, to];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.at(middle, 0) < value) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
