// Colours of pictures and plots, light and dark, as Quasar's class on the body says.

export const dark = () => document.body.classList.contains("body--dark");

// As model/palette.py has them, in custom properties of the body.
const ROWS = ["moments", "along", "series"];
const NAMES =
  "background ink faint grid axis link edge joint body panel tail centre kick present".split(" ");
const themes = new Map();

export function theme() {
  if (!themes.has(dark())) {
    const style = getComputedStyle(document.body);
    const read = (name) => style.getPropertyValue(`--rg-${name}`).trim();
    const row = (name) => read(name).split(/\s*,\s*/);
    const one = NAMES.map((name) => [name, read(name)]);
    themes.set(dark(), Object.fromEntries([...one, ...ROWS.map((name) => [name, row(name)])]));
  }
  return themes.get(dark());
}

const channels = (colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
const tables = new Map();

// `count` colours along stops that are evenly spaced; made once, as numbers: the browser would mix
// them itself, but anew for every stroke.
export function classes(stops, count) {
  const key = `${stops.join()}/${count}`;
  const colour = (_, k) => {
    const place = (k / (count - 1)) * (stops.length - 1);
    const at = Math.min(Math.floor(place), stops.length - 2);
    const [from, to] = [channels(stops[at]), channels(stops[at + 1])];
    return `rgb(${from.map((c, j) => Math.round(c + (to[j] - c) * (place - at))).join(",")})`;
  };
  if (!tables.has(key)) tables.set(key, Array.from({ length: count }, colour));
  return tables.get(key);
}
