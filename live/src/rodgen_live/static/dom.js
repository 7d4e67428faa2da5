// Helpers to build elements, to listen to them, and to hand files to the downloads of the browser.

export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== false && value !== null)
      element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

// A button with an icon of Material Icons and a label for those who do not see it.
export function button(icon, label, onclick) {
  const sign = make("i", { class: "material-icons", "aria-hidden": "true" }, icon);
  return make("button", { type: "button", "aria-label": label, title: label, onclick }, sign);
}

export function relabel(element, icon, label) {
  element.firstChild.textContent = icon;
  element.setAttribute("aria-label", label);
  element.title = label;
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
