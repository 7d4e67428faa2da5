// Rows of a plot by columns, of which the last are kept; and the range of their values.

export const MOST = 20000;
const FIRST = 512;
const SPARE = 1.25; // times as much room as rows: what is kept is moved to the front that rarely

export class Rows {
  total = 0; // rows that have come; the last `length` of them are kept
  length = 0;
  #begin = 0; // where the first of them stands
  #room = FIRST;

  constructor(columns) {
    this.columns = columns;
    this.data = Array.from({ length: columns }, () => new Float64Array(FIRST));
  }

  get first() {
    return this.total - this.length;
  }

  // Rows one after the other; what does not make a whole row is left out.
  append(values) {
    const { columns } = this;
    const rows = Math.floor(values.length / columns);
    const from = Math.max(0, rows - MOST);
    this.#drop(Math.max(0, this.length + rows - from - MOST));
    this.#reserve(rows - from);
    const at = this.#begin + this.length - from;
    this.data.forEach((column, k) => {
      for (let row = from; row < rows; row++) column[at + row] = values[row * columns + k];
    });
    this.length += rows - from;
    this.total += rows;
  }

  #drop(rows) {
    const gone = Math.min(rows, this.length);
    this.#begin += gone;
    this.length -= gone;
  }

  // Room for so many rows more, in larger columns or by moving those kept to the front.
  #reserve(rows) {
    const [needed, end] = [this.length + rows, this.#begin + this.length];
    if (end + rows <= this.#room) return;
    if (SPARE * needed > this.#room) {
      this.#room = Math.min(Math.max(2 * this.#room, needed), SPARE * MOST);
      this.data = this.data.map((column) => {
        const larger = new Float64Array(this.#room);
        larger.set(column.subarray(this.#begin, end));
        return larger;
      });
    } else {
      for (const column of this.data) column.copyWithin(0, this.#begin, end);
    }
    this.#begin = 0;
  }

  // By the number that the row had when it came.
  at(row, column) {
    return this.data[column][this.#begin + row - this.first];
  }

  // A column of rows from..to (exclusive): a view, which the next append may change.
  column(k, from, to) {
    const shift = this.#begin - this.first;
    return this.data[k].subarray(from + shift, to + shift);
  }

  // The first of the rows from..to (exclusive) with x at or above `value`; x ascends.
  search(value, from, to) {
    return from + lowest(this.column(0, from, to), value);
  }
}

// The first place in ascending values that is at or above `value`.
export function lowest(values, value) {
  let [low, high] = [0, values.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

// Values, each without its whole turns.
export function folded(values, turn) {
  if (!values.some((value) => Math.abs(value) > turn / 2)) return values;
  return values.map((value) => value - turn * Math.round(value / turn) || 0);
}

// The mean of all finite values of some columns; 0 without any.
export function mean(columns) {
  let [sum, count] = [0, 0];
  for (const values of columns) {
    for (const value of values) {
      if (!Number.isFinite(value)) continue;
      sum += value;
      count += 1;
    }
  }
  return sum / (count || 1);
}

// Least and largest finite value of some columns.
export function bounds(columns) {
  let [low, high] = [Infinity, -Infinity];
  for (const values of columns) {
    for (const value of values) {
      if (value < low && value > -Infinity) low = value;
      if (value > high && value < Infinity) high = value;
    }
  }
  return [low, high];
}
