// The rod with its displacements drawn larger than they are, so that small vibrations are seen.

// The straight rod that displacements are counted from, as [x, y, direction x, direction y] of its
// start: of a clamped rod that of its clamp; else the chord, from the start of a pinned rod, or
// through the middle of the joints.
function straight(joints, lengths, support, clampAngle) {
  const [x, y] = joints;
  if (support === "wall") return [x, y, Math.cos(clampAngle), Math.sin(clampAngle)];
  const [dx, dy] = [joints.at(-2) - x, joints.at(-1) - y];
  const chord = Math.hypot(dx, dy) || 1;
  const [c, s] = [dx / chord, dy / chord];
  if (support === "pin") return [x, y, c, s];
  const count = joints.length / 2;
  let [sumX, sumY, along] = [0, 0, 0];
  for (let k = 0; k < count; k += 1) {
    along += lengths[k];
    sumX += joints[2 * k] - c * along;
    sumY += joints[2 * k + 1] - s * along;
  }
  return [sumX / count, sumY / count, c, s];
}

// Joints x0, y0, x1, ..., each as many times as far from the straight rod as it is.
export function enlarged(joints, times, support, clampAngle) {
  if (times === 1) return joints;
  const lengths = new Float64Array(joints.length / 2); // of the link before each joint
  for (let k = 1; k < lengths.length; k += 1) {
    const at = 2 * k;
    lengths[k] = Math.hypot(joints[at] - joints[at - 2], joints[at + 1] - joints[at - 1]);
  }
  const [x, y, c, s] = straight(joints, lengths, support, clampAngle);
  const found = new Float64Array(joints.length);
  let along = 0;
  for (let k = 0; k < lengths.length; k += 1) {
    along += lengths[k];
    const [fromX, fromY] = [x + c * along, y + s * along];
    found[2 * k] = fromX + times * (joints[2 * k] - fromX);
    found[2 * k + 1] = fromY + times * (joints[2 * k + 1] - fromY);
  }
  return found;
}
