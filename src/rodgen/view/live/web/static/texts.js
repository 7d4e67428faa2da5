// Texts by key, written into every element that has data-text="key".

export class Texts {
  #texts = new Map();
  changed = false;

  set(texts) {
    this.changed = true;
    for (const [key, text] of Object.entries(texts)) this.#texts.set(key, String(text));
  }

  // Only what differs is written: elements may come later than their text, or be rendered anew.
  write() {
    this.changed = false;
    for (const element of document.querySelectorAll("[data-text]")) {
      const text = this.#texts.get(element.dataset.text);
      if (text !== undefined && element.textContent !== text) put(element, text);
    }
  }
}

function put(element, text) {
  const only = element.childNodes.length === 1 ? element.firstChild : null;
  // The node is kept where it can be: Vue, which may have made it, goes on with it.
  if (only?.nodeType === Node.TEXT_NODE) only.nodeValue = text;
  else element.textContent = text;
}
