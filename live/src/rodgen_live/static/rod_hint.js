// What a link is doing, told beside the pointer that is upon it.

import { short } from "./scales.js";

const NEAR = 12; // pixels from a link that still meet it

// The link that (px, py) is upon, or null: {link, share, distance}, in pixels; points: x0, y0, ...
export function met(points, px, py) {
  let best = { distance: Infinity };
  for (let at = 0; at + 3 < points.length; at += 2) {
    const [x, y] = [points[at], points[at + 1]];
    const [dx, dy] = [points[at + 2] - x, points[at + 3] - y];
    const square = dx * dx + dy * dy;
    const along = square > 0 ? ((px - x) * dx + (py - y) * dy) / square : 0;
    const share = Math.min(Math.max(along, 0), 1);
    const distance = Math.hypot(x + share * dx - px, y + share * dy - py);
    if (distance < best.distance) best = { link: at / 2, share, distance };
  }
  return best.distance <= NEAR ? best : null;
}

// Axial and shear forces in the joints at the ends of a link, of those that have them: the last
// ones of the joints before the tail.
function passed(section, links, link) {
  const first = links - section.length / 2;
  const at = [link, link + 1].filter((joint) => joint >= first && joint < links);
  if (!at.length) return [];
  return ["N", "Q"].map((name, k) => {
    const values = at.map((joint) => short(section[2 * (joint - first) + k], 3));
    return `${name} = ${values.join(" and ")} N ${at.length > 1 ? "at its joints" : "at its joint"}`;
  });
}

// What there is to say of a link: its number, angle and rate, moments at its joints, forces there.
export function said({ joints, omega, moment, section, forces }, loads, link) {
  const at = 2 * link;
  const phi = Math.atan2(joints[at + 3] - joints[at + 1], joints[at + 2] - joints[at]);
  const rows = [
    `link ${link}`,
    `\u03c6 = ${short(phi)} rad (${short((180 / Math.PI) * phi, 3)}\u00b0)`,
  ];
  if (omega) rows.push(`\u03c9 = ${short(omega[link])} rad/s`);
  if (moment) {
    const [first, last] = [moment[link], moment[link + 1]].map((m) => short(m, 3));
    rows.push(`M = ${first} and ${last} N m at its joints`);
  }
  if (section) rows.push(...passed(section, joints.length / 2 - 1, link));
  for (const { term, label } of loads) {
    const part = forces[term]?.subarray(at, at + 4);
    if (part?.length !== 4) continue; // a force on each joint, or an acceleration of all
    const size = Math.hypot(part[0] + part[2], part[1] + part[3]);
    if (size > 0) rows.push(`${label} ${short(size, 3)} N at its joints`);
  }
  return rows;
}
