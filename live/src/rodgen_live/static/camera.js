// From metres to pixels and back: where the picture looks, how large, what it follows; and which part
// of the world shows a rod well.

const [LEAST, MOST] = [1e-9, 1e9]; // pixels per metre
const ROOM = 35; // pixels left free about what is fitted
const [ACROSS, UP] = [[0, 2], [1, 3]]; // ends of a box

export class Camera {
  width = 1;
  height = 1;
  scale = 100; // pixels per metre
  mode = "fixed";
  #u = 0; // middle of the picture from the anchor, in its turned axes [m]
  #v = 0;
  #from = [0, 0]; // what a fixed view is anchored to: absolute, in doubles
  #x = 0; // the anchor, relative to the origin of the state
  #y = 0;
  #cos = 1;
  #sin = 0;
  #turned = 0;

  get angle() {
    return this.mode === "axes" ? this.#turned : 0;
  }

  // A text of what a fixed view shows; null where the view follows.
  get place() {
    return this.mode === "fixed" ? [...this.#from, this.#u, this.#v, this.scale].join() : null;
  }

  // Takes up a state: its origin, and of `point` the centre of gravity and the angle of an axis.
  follow(origin, point) {
    const [x, y] = [origin[0] - this.#from[0], origin[1] - this.#from[1]];
    if (this.mode === "fixed" || !point) [this.#x, this.#y] = [-x, -y];
    // A run that has blown up leaves the picture where it was.
    else if (Number.isFinite(point[0] + point[1])) [this.#x, this.#y] = [point[0], point[1]];
    // An axis has no direction: of its two angles, half a turn apart, the one nearer to the last.
    if (Number.isFinite(point?.[2])) {
      const change = point[2] - this.#turned;
      this.#turned += change - Math.PI * Math.round(change / Math.PI);
    }
    [this.#cos, this.#sin] = [Math.cos(this.angle), Math.sin(this.angle)];
  }

  // Another mode, with the same centre of gravity in the same place.
  change(mode, origin, point) {
    const before = point ? this.screen(point[0], point[1]) : null;
    this.mode = mode;
    this.#from = [...origin];
    this.follow(origin, point);
    if (!before) return;
    const after = this.screen(point[0], point[1]);
    this.pan(before[0] - after[0], before[1] - after[1]);
  }

  screen(x, y) {
    const [dx, dy] = [x - this.#x, y - this.#y];
    return [
      this.width / 2 + (this.#cos * dx + this.#sin * dy - this.#u) * this.scale,
      this.height / 2 - (-this.#sin * dx + this.#cos * dy - this.#v) * this.scale,
    ];
  }

  // All of x0, y0, x1, y1, ... into `points`, in pixels.
  project(joints, points) {
    const [c, s, k] = [this.#cos * this.scale, this.#sin * this.scale, this.scale];
    const [left, top] = [this.width / 2 - this.#u * k, this.height / 2 + this.#v * k];
    for (let at = 0; at < joints.length; at += 2) {
      const [dx, dy] = [joints[at] - this.#x, joints[at + 1] - this.#y];
      points[at] = left + c * dx + s * dy;
      points[at + 1] = top + s * dx - c * dy;
    }
  }

  // Metres, relative to the origin of the state, of a place in the picture.
  world(px, py) {
    const [dx, dy] = this.metres(px - this.width / 2, py - this.height / 2);
    const [ux, uy] = [
      this.#cos * this.#u - this.#sin * this.#v,
      this.#sin * this.#u + this.#cos * this.#v,
    ];
    return [this.#x + ux + dx, this.#y + uy + dy];
  }

  // Pixels of a displacement as metres along x and y.
  metres(px, py) {
    const [u, v] = [px / this.scale, -py / this.scale];
    return [this.#cos * u - this.#sin * v, this.#sin * u + this.#cos * v];
  }

  // Direction of a vector (x, y) in the picture, in pixels per unit of length.
  direction(x, y) {
    return [this.#cos * x + this.#sin * y, this.#sin * x - this.#cos * y];
  }

  pan(px, py) {
    this.#u -= px / this.scale;
    this.#v += py / this.scale;
  }

  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const scale = Math.min(Math.max(this.scale * factor, LEAST), MOST);
    const [dx, dy] = [px - this.width / 2, py - this.height / 2];
    this.#u += dx * (1 / this.scale - 1 / scale);
    this.#v -= dy * (1 / this.scale - 1 / scale);
    this.scale = scale;
  }

  // Shows, in metres from the anchor, `shown` at a place in the picture (`fitted`).
  fit({ scale, at, shown }, origin, point) {
    this.#from = [...origin];
    this.follow(origin, point);
    this.scale = scale;
    this.#u = shown[0] - (at[0] - this.width / 2) / scale;
    this.#v = shown[1] + (at[1] - this.height / 2) / scale;
  }
}

// The box about two boxes.
export const about = (one, other) =>
  one.map((end, k) => (k < 2 ? Math.min(end, other[k]) : Math.max(end, other[k])));

// The box about the joints, [left, bottom, right, top], the length of the rod, and how far it
// reaches from the centre of gravity.
export function size(places, point) {
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  let [length, reach] = [0, 0];
  for (let at = 0; at < places.length; at += 2) {
    const [x, y] = [places[at], places[at + 1]];
    if (!Number.isFinite(x + y)) continue;
    [box[0], box[1]] = [Math.min(box[0], x), Math.min(box[1], y)];
    [box[2], box[3]] = [Math.max(box[2], x), Math.max(box[3], y)];
    if (at) length += Math.hypot(x - places[at - 2], y - places[at - 1]) || 0;
    if (point) reach = Math.max(reach, Math.hypot(x - point[0], y - point[1]));
  }
  return { box, length, reach };
}

const square = (x, y, wide, high) => [x - wide, y - high, x + wide, y + high];

// What to fit, as [{box, room (pixels about it)}, ...], in metres from what the view is anchored to:
// for a view that follows, how far the rod reaches however it turns (along the first principal axis
// it is long and not high); for a pinned rod the circle that it can reach; else the rod with room
// beside it; and `fixed`, the points that
// hold it. `arrow`: pixels of the longest arrow at the tail, 0 where there is none.
export function around(places, point, mode, support, arrow, fixed) {
  const { box, length, reach } = size(places, point);
  const whole = Math.max(ROOM, arrow);
  if (!(length > 0)) return [{ box: [-1, -1, 1, 1], room: ROOM }];
  const [x, y] = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
  if (mode !== "fixed") {
    const far = Math.max(reach, length / 2);
    return [{ box: square(0, 0, far, mode === "axes" ? 0.6 * far : far), room: whole }];
  }
  const holding = fixed.map((place) => ({ box: [...place, ...place], room: ROOM }));
  if (support === "pin") {
    return [{ box: square(places[0], places[1], length, length), room: whole }, ...holding];
  }
  const roomy = about(box, square(x, y, length / 2, length / 2));
  const tail = places.slice(-2);
  const parts = [{ box: roomy, room: ROOM }, ...holding];
  if (Number.isFinite(tail[0] + tail[1])) parts.push({ box: [...tail, ...tail], room: whole });
  return parts;
}

// The largest scale at which all parts, from box[low] to box[high], fit into so many pixels.
function largest(parts, [low, high], pixels) {
  let scale = Infinity;
  for (const first of parts) {
    for (const last of parts) {
      const length = last.box[high] - first.box[low];
      const free = Math.max(pixels - first.room - last.room, pixels / 3);
      if (length > 0) scale = Math.min(scale, free / length);
    }
  }
  return scale;
}

// The ends of all parts with the room about them [m].
function ends(parts, [low, high], scale) {
  return [
    Math.min(...parts.map(({ box, room }) => box[low] - room / scale)),
    Math.max(...parts.map(({ box, room }) => box[high] + room / scale)),
  ];
}

// Fits the parts into the piece [x, y, width, height] of a picture; half: pixels from its middle to
// the ends of what is fitted.
function into(parts, [x, y, width, height]) {
  const scale = Math.min(largest(parts, ACROSS, width), largest(parts, UP, height));
  const [[left, right], [bottom, top]] = [ACROSS, UP].map((along) => ends(parts, along, scale));
  return {
    scale,
    at: [x + width / 2, y + height / 2],
    shown: [(left + right) / 2, (bottom + top) / 2],
    half: [((right - left) / 2) * scale, ((top - bottom) / 2) * scale],
  };
}

// {scale, at: a place in the picture [pixels], shown: what is to be seen there [m]}, so that the
// parts are as large as a picture of this size allows; beside or below the legend, whose left and
// lower edge are given, where they would be behind it.
export function fitted(parts, [width, height], [left, low]) {
  const whole = into(parts, [0, 0, width, height]);
  const hidden = whole.at[0] + whole.half[0] > left && whole.at[1] - whole.half[1] < low;
  if (!hidden) return whole;
  const [beside, below] = [
    [0, 0, left, height],
    [0, low, width, height - low],
  ].map((piece) => into(parts, piece));
  return beside.scale > below.scale ? beside : below;
}
