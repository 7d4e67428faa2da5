// Which part of the world shows a rod well.

// The box about the joints, [left, bottom, right, top], the length of the rod, and how far it
// reaches from the centre of gravity.
function size(places, point) {
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

const about = (x, y, wide, high) => [x - wide, y - high, x + wide, y + high];

// What to fit: for a view that follows, how far the rod reaches however it turns (along the first
// principal axis it is long and not high); for a pinned rod the circle that it can reach; else the
// rod with room beside it.
export function around(places, point, mode, support) {
  const { box, length, reach } = size(places, point);
  if (!(length > 0)) return [-1, -1, 1, 1];
  const [x, y] = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
  if (mode !== "fixed") {
    const far = Math.max(reach, length / 2);
    return about(x, y, far, mode === "axes" ? 0.6 * far : far);
  }
  if (support === "pinned") return about(places[0], places[1], length, length);
  const room = about(x, y, length / 2, length / 2);
  return [
    ...box.slice(0, 2).map((low, k) => Math.min(low, room[k])),
    ...box.slice(2).map((high, k) => Math.max(high, room[k + 2])),
  ];
}
