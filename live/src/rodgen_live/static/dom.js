// Helpers to build elements, to listen to them, and to hand files to the downloads of the browser.

export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

// A button with an icon of Material Icons, or with letters, and a label for who does not see it.
export function button(sign, label, onclick) {
  const icon = () => make("i", { class: "material-icons", "aria-hidden": "true" }, sign);
  const shown = /^[a-z_]{3,}$/.test(sign) ? icon() : sign;
  return make("button", { type: "button", "aria-label": label, title: label, onclick }, shown);
}

export function relabel(element, icon, label) {
  element.firstChild.textContent = icon;
  element.setAttribute("aria-label", label);
  element.title = label;
}

const APART = 10; // pixels from a place to what is said of it

// Says lines of text in a box, beside a place in pixels of what it lies in; hides it without any.
export function tell(box, lines, place) {
  box.hidden = !lines.length;
  if (box.hidden) return;
  box.textContent = lines.join("\n");
  const [[x, y], { offsetWidth, offsetHeight, parentElement: around }] = [place, box];
  const left = x > around.clientWidth / 2 ? x - APART - offsetWidth : x + APART;
  const within = (from, room) => Math.max(Math.min(from, room), 0);
  const right = within(left, around.clientWidth - offsetWidth);
  const down = within(y - offsetHeight / 2, around.clientHeight - offsetHeight);
  box.style.transform = `translate(${right}px, ${down}px)`;
}

// Listens to several events of an element, which handlers may prevent.
export function listen(element, handlers) {
  for (const [name, handler] of Object.entries(handlers))
    element.addEventListener(name, handler, { passive: false });
}

// Where in an element an event happened, in pixels.
export function placeOf(event, element) {
  const box = element.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
}

// Pixels by which a wheel was turned; some browsers tell lines.
export const turned = (event) => event.deltaY * (event.deltaMode === 1 ? 33 : 1);

// Has done, by `by`, what a key does of `keys`, unless it is a shortcut of the browser.
export function act(event, keys, by = (move) => move()) {
  if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
  event.preventDefault();
  by(keys[event.key]);
}

export function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // The download has begun by then; the memory is given back.
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// A name that every file system takes.
export const named = (title, ending) =>
  `${title.replace(/[^\p{L}\p{N}]+/gu, "_").replace(/^_+|_+$/g, "") || "plot"}.${ending}`;
