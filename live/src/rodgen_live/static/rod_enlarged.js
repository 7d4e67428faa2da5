// The rod with its displacements drawn larger than they are, so that small vibrations are seen.

// The straight rod that displacements are counted from, as [x, y, direction x, direction y] of its
// start: of a clamped rod that of its clamp; else the chord, from the start of a pinned rod, or
// through the middle of the joints.
function straight(joints, along, support, clampAngle) {
  const [x, y] = joints;
  if (support === "wall") return [x, y, Math.cos(clampAngle), Math.sin(clampAngle)];
  const [dx, dy] = [joints.at(-2) - x, joints.at(-1) - y];
  const chord = Math.hypot(dx, dy) || 1;
  const [c, s] = [dx / chord, dy / chord];
  if (support === "pin") return [x, y, c, s];
  let [sumX, sumY] = [0, 0];
  along.forEach((length, k) => {
    sumX += joints[2 * k] - c * length;
    sumY += joints[2 * k + 1] - s * length;
  });
  return [sumX / along.length, sumY / along.length, c, s];
}

// Joints x0, y0, x1, ..., each as many times as far from the straight rod as it is.
export function enlarged(joints, times, support, clampAngle) {
  if (times === 1) return joints;
  const along = new Float64Array(joints.length / 2); // of the rod before each joint
  for (let at = 2; at < joints.length; at += 2) {
    const link = Math.hypot(joints[at] - joints[at - 2], joints[at + 1] - joints[at - 1]);
    along[at / 2] = along[at / 2 - 1] + link;
  }
  const [x, y, c, s] = straight(joints, along, support, clampAngle);
  return Float64Array.from(joints, (place, at) => {
    const from = at % 2 ? y + s * along[(at - 1) / 2] : x + c * along[at / 2];
    return from + times * (place - from);
  });
}
