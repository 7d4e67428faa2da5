// Rows of a plot by columns, of which the last are kept; and the range of their values.

export const MOST = 20000;
const FIRST = 512;
const SPARE = 1.25; // times as much room as rows: what is kept is moved to the front that rarely

export class Rows {
  total = 0; // rows that have come; the last `length` of them are kept
  length = 0;
  #begin = 0; // where the first of them stands

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
    const fresh = Math.min(rows, MOST);
    const kept = Math.min(this.length, MOST - fresh);
    this.#begin += this.length - kept;
    if (this.#begin + kept + fresh > this.data[0].length) this.#move(kept, fresh);
    const at = this.#begin + kept;
    const from = (rows - fresh) * columns;
    this.data.forEach((column, k) => {
      for (let row = 0; row < fresh; row++) column[at + row] = values[from + row * columns + k];
    });
    this.length = kept + fresh;
    this.total += rows;
  }

  // What is kept goes to the front of columns with room for so many rows more.
  #move(kept, fresh) {
    const room = Math.min(2 * (kept + fresh), SPARE * MOST);
    const from = this.#begin;
    this.data = this.data.map((column) => {
      const larger = new Float64Array(room);
      larger.set(column.subarray(from, from + kept));
      return larger;
    });
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

// The place of the value in ascending ones that is nearest to one.
export function nearest(values, value) {
  const at = Math.min(lowest(values, value), values.length - 1);
  return at && value - values[at - 1] < values[at] - value ? at - 1 : at;
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
