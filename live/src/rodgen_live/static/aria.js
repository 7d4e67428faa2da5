// What Quasar leaves unsaid to screen readers: the part of a slider that has the focus is the slider,
// and a list holds nothing but its options. It shows nothing.

const SLIDER = ".q-slider[role=slider]";
const LISTED = "[role=listbox] > .q-virtual-scroll__content";
const SAID = ["label", "valuetext", "valuenow", "valuemin", "valuemax", "orientation"].map(
  (name) => `aria-${name}`,
);

function say(slider) {
  const part = slider.querySelector("[tabindex]");
  part?.setAttribute("role", "slider");
  for (const name of SAID) {
    const said = slider.getAttribute(name);
    if (said === null) continue;
    part?.setAttribute(name, said);
    if (name !== SAID[0]) slider.removeAttribute(name);
  }
}

function mend(root) {
  for (const slider of root.querySelectorAll(SLIDER)) {
    slider.setAttribute("role", "group");
    say(slider);
  }
  for (const list of root.querySelectorAll(LISTED)) list.removeAttribute("tabindex");
}

function look(changes) {
  for (const { type, target, addedNodes } of changes) {
    if (type === "attributes") {
      if (target.matches(".q-slider")) say(target);
    } else if (addedNodes.length) mend(target);
  }
}

export default {
  template: "<div hidden></div>",
  mounted() {
    this.observer = new MutationObserver(look);
    const what = { childList: true, subtree: true, attributeFilter: SAID };
    this.observer.observe(document.body, what);
    mend(document.body);
  },
  beforeUnmount() {
    this.observer.disconnect();
  },
};
