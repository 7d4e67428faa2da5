// Colours of pictures and plots, light and dark, as Quasar's class on the body says.

export const dark = () => document.body.classList.contains("body--dark");

const LIGHT = {
  background: "#ffffff",
  ink: "#20242b",
  faint: "#5b6470",
  grid: "#e7eaee",
  axis: "#b4bcc6",
  link: "#52657d",
  edge: "#20242b",
  joint: "#ffffff",
  panel: "rgba(255,255,255,0.82)",
  tail: "#64748b",
  centre: "#0f766e",
  principal: "#0f766e",
  kick: "#dc2626",
  present: "#c2410c",
  moments: ["#08519c", "#4a90c9", "#a7adb5", "#e0705a", "#a50f15"],
  along: ["#440154", "#3b528b", "#21918c", "#3fa34d", "#b59d00"],
  series: ["#0068b5", "#c2410c", "#0f8a5f", "#a8327e", "#7a6a00", "#0891b2", "#6d28d9", "#4b5563"],
};
const DARK = {
  background: "#16191d",
  ink: "#e8eaed",
  faint: "#a2abb6",
  grid: "#262b31",
  axis: "#4a525c",
  link: "#9fb3c8",
  edge: "#0b0d0f",
  joint: "#f1f3f5",
  panel: "rgba(22,25,29,0.82)",
  tail: "#94a3b8",
  centre: "#5eead4",
  principal: "#5eead4",
  kick: "#f87171",
  present: "#fb923c",
  moments: ["#3b9cff", "#7cb8ee", "#808994", "#f0907a", "#ff4d4d"],
  along: ["#8f7bff", "#5aa0ff", "#35c9c0", "#8ddf5f", "#fde725"],
  series: ["#5ab4ff", "#ff944d", "#3fd6a5", "#f29bc6", "#e8c547", "#67e8f9", "#b794ff", "#c9ced6"],
};

export const theme = () => (dark() ? DARK : LIGHT);

const channels = (colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));

// The colour at `share` (0 to 1) between stops that are evenly spaced.
export function blend(stops, share) {
  const place = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const at = Math.min(Math.floor(place), stops.length - 2);
  const [from, to] = [channels(stops[at]), channels(stops[at + 1])];
  const mixed = from.map((c, k) => Math.round(c + (to[k] - c) * (place - at)));
  return `rgb(${mixed.join(",")})`;
}

const tables = new Map();

// `count` colours along stops; made once.
export function classes(stops, count) {
  const key = `${stops.join()}/${count}`;
  if (!tables.has(key)) {
    tables.set(
      key,
      Array.from({ length: count }, (_, k) => blend(stops, k / (count - 1))),
    );
  }
  return tables.get(key);
}
