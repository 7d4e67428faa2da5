// From metres to pixels and back: where the picture looks, how large, what it follows; and which part
// of the world shows a rod well.

const [LEAST, MOST] = [1e-9, 1e9]; // pixels per metre

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

  // Shows what `fitted` gives, in metres from the anchor.
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

// The box to fit, in metres from what the view is anchored to: for a view that follows, how far the
// rod reaches however it turns (along the first principal axis it is long and not high); for a
// pinned rod the circle that it can reach; else the rod with room beside it; and `fixed`, the points
// that hold it.
export function around(places, point, mode, support, fixed) {
  const { box, length, reach } = size(places, point);
  if (!(length > 0)) return [-1, -1, 1, 1];
  if (mode !== "fixed") {
    const far = Math.max(reach, length / 2);
    return square(0, 0, far, mode === "axes" ? 0.6 * far : far);
  }
  const middle = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
  const roomy =
    support === "pin"
      ? square(places[0], places[1], length, length)
      : square(...middle, length / 2, length / 2);
  return fixed.reduce((found, place) => about(found, [...place, ...place]), about(box, roomy));
}

// {scale, at: a place in the picture [pixels], shown: what is to be seen there [m]}, so that a box
// with so many pixels of room about it fits into the piece [x, y, width, height] of the picture.
function into([left, bottom, right, top], room, [x, y, width, height]) {
  const free = (pixels) => Math.max(pixels - 2 * room, pixels / 3);
  const scale = Math.min(free(width) / (right - left), free(height) / (top - bottom));
  const [at, shown] = [
    [x + width / 2, y + height / 2],
    [(left + right) / 2, (bottom + top) / 2],
  ];
  return { scale, at, shown };
}

// The larger view of a box beside or below the legend, whose left and lower edge are given.
export function fitted(box, room, [width, height], [left, low]) {
  const beside = into(box, room, [0, 0, left, height]);
  const below = into(box, room, [0, low, width, height - low]);
  return beside.scale > below.scale ? beside : below;
}
