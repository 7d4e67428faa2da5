// Small helpers to build elements of the page.

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
