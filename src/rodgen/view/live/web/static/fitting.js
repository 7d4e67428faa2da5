// Which part of the world shows a rod well, and at which scale.

const ROOM = 35; // pixels left free about what is fitted

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

// What to fit, as [{box, room (pixels about it)}, ...], in metres from what the view is anchored to:
// for a view that follows, how far the rod
// reaches however it turns (along the first principal axis it is long and not high); for a pinned
// rod the circle that it can reach; else the rod with room beside it. `arrow`: pixels of the
// longest arrow at the tail, 0 where there is none.
export function around(places, point, mode, support, arrow) {
  const { box, length, reach } = size(places, point);
  const whole = Math.max(ROOM, arrow);
  if (!(length > 0)) return [{ box: [-1, -1, 1, 1], room: ROOM }];
  const [x, y] = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
  if (mode !== "fixed") {
    const far = Math.max(reach, length / 2);
    return [{ box: about(0, 0, far, mode === "axes" ? 0.6 * far : far), room: whole }];
  }
  if (support === "pinned") {
    return [{ box: about(places[0], places[1], length, length), room: whole }];
  }
  const room = about(x, y, length / 2, length / 2);
  const roomy = box.map((end, k) => (k < 2 ? Math.min(end, room[k]) : Math.max(end, room[k])));
  const tail = places.slice(-2);
  const parts = [{ box: roomy, room: ROOM }];
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

const ACROSS = [0, 2];
const UP = [1, 3];

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
