// The rod with its displacements drawn larger than they are, so that small vibrations are seen.

// The joints x0, y0, x1, ... of the rod at rest, whose links have the angles of restShape over that
// at its start: of a clamped rod from its clamp on; else as near to the joints as a rotation brings
// it, about the start of a pinned rod, or about the middle of the joints.
function atRest({ joints, point }, { support, restShape }) {
  const seen = Array.from({ length: joints.length / 2 }, (_, k) => joints.slice(2 * k, 2 * k + 2));
  const rest = [[0, 0]];
  seen.slice(1).forEach(([x, y], k) => {
    const link = Math.hypot(x - seen[k][0], y - seen[k][1]);
    const turned = restShape[k] ?? 0; // while another rod is awaited
    rest.push([rest[k][0] + link * Math.cos(turned), rest[k][1] + link * Math.sin(turned)]);
  });
  const middle = (of) => [0, 1].map((axis) => of.reduce((sum, at) => sum + at[axis], 0) / of.length);
  const [[u0, v0], [x0, y0]] = [rest, seen].map(support === "none" ? middle : ([start]) => start);
  let [along, across] = [0, 0];
  rest.forEach(([u, v], k) => {
    along += (u - u0) * (seen[k][0] - x0) + (v - v0) * (seen[k][1] - y0);
    across += (u - u0) * (seen[k][1] - y0) - (v - v0) * (seen[k][0] - x0);
  });
  const angle = support === "wall" ? (point?.[3] ?? 0) : Math.atan2(across, along);
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const place = ([u, v]) => [x0 + c * (u - u0) - s * (v - v0), y0 + s * (u - u0) + c * (v - v0)];
  return rest.flatMap(place);
}

// Joints, each as many times as far from the rod at rest as it is.
export function enlarged(state, options) {
  if (options.times === 1) return state.joints;
  const rest = atRest(state, options);
  return Float64Array.from(state.joints, (x, at) => rest[at] + options.times * (x - rest[at]));
}
