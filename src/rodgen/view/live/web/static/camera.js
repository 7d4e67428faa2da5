// From metres to pixels and back: where the picture looks, how large, and what it follows.

const MOST = 1e9;
const LEAST = 1e-9;

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

  // Shows, in metres from the anchor, `shown` at a place in the picture (fitting.js).
  fit({ scale, at, shown }, origin, point) {
    this.#from = [...origin];
    this.follow(origin, point);
    this.scale = scale;
    this.#u = shown[0] - (at[0] - this.width / 2) / scale;
    this.#v = shown[1] + (at[1] - this.height / 2) / scale;
  }
}
