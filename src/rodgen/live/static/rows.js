// Rows of a plot in a ring of doubles, bounded; and as many points of them as a picture can show.

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

// x, y of rows from..to (exclusive): where there are more than two a column, the least and the
// largest of each column `width` wide. Columns stand at multiples of the width, so that they do
// not tremble while the window moves on.
export function extremes(rows, column, from, to, width) {
  const out = [];
  let [place, low, high] = [null, -1, -1];
  const flush = () => {
    if (low < 0) return;
    for (const row of low === high ? [low] : [Math.min(low, high), Math.max(low, high)]) {
      out.push(rows.at(row, 0), rows.at(row, column));
    }
    low = high = -1;
  };
  for (let row = from; row < to; row++) {
    const [x, y] = [rows.at(row, 0), rows.at(row, column)];
    const now = Math.floor(x / width);
    if (now !== place || Number.isNaN(y)) flush();
    place = now;
    if (Number.isNaN(y)) out.push(x, NaN);
    else if (low < 0) low = high = row;
    else if (y < rows.at(low, column)) low = row;
    else if (y > rows.at(high, column)) high = row;
  }
  flush();
  return Float64Array.from(out);
}

// Columns x and y of rows from..to (exclusive).
export function whole(rows, x, y, from, to) {
  const out = new Float64Array(2 * (to - from));
  for (let row = from, at = 0; row < to; row++, at += 2) {
    out[at] = rows.at(row, x);
    out[at + 1] = rows.at(row, y);
  }
  return out;
}

// A curve in the plane without the points that lie within (dx, dy) of the last one taken.
export function spaced(rows, column, other, from, to, dx, dy) {
  const out = [];
  let [px, py] = [Infinity, Infinity];
  for (let row = from; row < to; row++) {
    const [x, y] = [rows.at(row, column), rows.at(row, other)];
    if (row < to - 1 && Math.abs(x - px) < dx && Math.abs(y - py) < dy) continue;
    out.push(x, y);
    [px, py] = [x, y];
  }
  return Float64Array.from(out);
}

// Least and largest finite value of columns first..last (exclusive) in rows from..to (exclusive).
export function bounds(rows, first, last, from, to) {
  let [low, high] = [Infinity, -Infinity];
  for (let row = from; row < to; row++) {
    for (let column = first; column < last; column++) {
      const value = rows.at(row, column);
      if (value < low && value > -Infinity) low = value;
      if (value > high && value < Infinity) high = value;
    }
  }
  return [low, high];
}
